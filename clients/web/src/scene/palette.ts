// Colours that tell objects apart, for every kind of colour vision.
import type { Vector3 } from "three";

// After Okabe and Ito (jfly.uni-koeln.de/color), without black and with the yellow darkened so that it
// stands out from white; wine and indigo after Paul Tol's "muted".
export const objectColors: readonly string[] = [
  "#e69f00", "#56b4e9", "#009e73", "#d55e00", "#0072b2", "#cc79a7", "#c8b400", "#882255", "#5b53b8"];

// Supports and residuals have muted colours, behind those of objects.
export const supportColors: readonly string[] = ["#8b9bb0", "#a79f93", "#7f958c"];
export const residualColors: readonly string[] = ["#9a9a9a", "#b3aea6", "#84898f", "#a5a9ad"];

export const repeated = (colors: readonly string[], index: number): string =>
  colors[index % colors.length] as string;

// One colour per place, such that neighbours differ: each place takes the colour whose nearest
// holder so far is farthest away, with ties resolved by order. The same places get the same
// colours.
export function colorsOfPlaces(places: readonly Vector3[]): string[] {
  const chosen: string[] = [];
  places.forEach((place, i) => {
    let best = objectColors[0] as string;
    let farthest = -1;
    for (const color of objectColors) {
      let nearest = Infinity;
      for (let k = 0; k < i; ++k) {
        if (chosen[k] === color) nearest = Math.min(nearest, place.distanceTo(places[k] as Vector3));
      }
      if (nearest > farthest) {
        farthest = nearest;
        best = color;
      }
    }
    chosen.push(best);
  });
  return chosen;
}
