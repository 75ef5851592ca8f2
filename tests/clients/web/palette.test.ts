import assert from "node:assert/strict";
import { test } from "node:test";
import { Vector3 } from "three";
import { colorsOfPlaces, objectColors } from "../../../clients/web/src/scene/palette";

const line = (count: number): Vector3[] => Array.from({ length: count }, (_, i) => new Vector3(i, 0, 0));

test("as many objects as colours have one each", () => {
  assert.equal(new Set(colorsOfPlaces(line(objectColors.length))).size, objectColors.length);
});

test("more objects than colours never share one with a neighbour", () => {
  const colors = colorsOfPlaces(line(5 * objectColors.length));
  colors.slice(1).forEach((color, i) => assert.notEqual(color, colors[i]));
});

// Relative luminance, WCAG 2.1.
function luminance(color: string): number {
  const [r, g, b] = [1, 3, 5].map((at) => {
    const channel = parseInt(color.slice(at, at + 2), 16) / 255;
    return channel <= 0.03928 ? channel / 12.92 : ((channel + 0.055) / 1.055) ** 2.4;
  }) as [number, number, number];
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

test("every colour stands out from a white and from a black page", () => {
  for (const color of objectColors) {
    assert.ok(1.05 / (luminance(color) + 0.05) >= 1.5, `${color} on white`);
    assert.ok((luminance(color) + 0.05) / 0.05 >= 1.5, `${color} on black`);
  }
});
