// The order of names in lists for people: object_2 before object_10.
export const naturalOrder = new Intl.Collator("en", { numeric: true });
