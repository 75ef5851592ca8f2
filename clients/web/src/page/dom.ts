// Elements made of text and other elements; nothing is ever parsed as HTML.
type Child = Node | string;

export function element<Tag extends keyof HTMLElementTagNameMap>(
    tag: Tag, className = "", ...children: Child[]): HTMLElementTagNameMap[Tag] {
  const made = document.createElement(tag);
  if (className !== "") made.className = className;
  made.append(...children);
  return made;
}

export function withTitle<Made extends HTMLElement>(made: Made, title: string): Made {
  made.title = title;
  return made;
}

// Adjacent numbers, each in a column of its own.
export function numbers(values: readonly string[]): HTMLElement {
  return element("span", "numbers", ...values.map((value) => element("span", "", value)));
}

// A patch in an object's colour.
export function swatch(color: string): HTMLElement {
  const patch = element("span", "swatch");
  patch.style.setProperty("--color", color);
  return patch;
}
