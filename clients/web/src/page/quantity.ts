// Formats numbers for people.

const thinSpace = "\u2009";
const minus = "\u2212";

// Fixed decimals with a true minus; a zero that rounding made negative is a zero.
export function fixed(value: number, decimals: number): string {
  const text = Math.abs(value).toFixed(decimals);
  return value < 0 && Number(text) !== 0 ? minus + text : text;
}

// Formats 307200 as "307 200".
export function count(value: number | string): string {
  return Number(value).toFixed(0).replace(/\B(?=(\d{3})+(?!\d))/g, thinSpace);
}

export const mm = (value_m: number, decimals = 1): string => fixed(1000 * value_m, decimals);

export const percent = (ratio: number, decimals = 1): string => fixed(100 * ratio, decimals);

export const degrees = (angle_rad: number, decimals = 2): string =>
  fixed((angle_rad * 180) / Math.PI, decimals);

export const ms = (value: number): string => (value < 1000 ? fixed(value, value < 10 ? 2 : 1) : count(value));

// "1 object", "2 objects".
export const plural = (number: number, noun: string): string =>
  `${count(number)} ${noun}${number === 1 ? "" : "s"}`;
