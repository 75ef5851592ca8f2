// Running sensors in words and numbers. Pure.
import { count, degrees, fixed, mm, percent } from "../page/quantity";
import type { PixelCounts, Sensor } from "../world/stream";
import type { LatencyParts } from "./picture_latency";
import { sumOf } from "./pixel_classes";

const ms = (value: number): string => fixed(value, value < 9.95 ? 1 : 0);

export function rateText({ is_streaming, frame_rate }: Sensor): string {
  return is_streaming ? `${fixed(frame_rate, frame_rate < 9.95 ? 1 : 0)} /s` : "stopped";
}

export function latencyText({ latency_p50_ms, latency_p95_ms, processed_count }: Sensor): string {
  return Number(processed_count) === 0 ? "" : `${ms(latency_p50_ms)} ms, p95 ${ms(latency_p95_ms)}`;
}

// The share of a class in the pixels of all these frames.
export function shareText(key: keyof PixelCounts, frames: readonly PixelCounts[]): string {
  const total = frames.reduce((sum, counts) => sum + sumOf(counts), 0);
  const own = frames.reduce((sum, counts) => sum + Number(counts[key]), 0);
  return total === 0 ? "" : `${percent(own / total, own / total < 0.0995 ? 1 : 0)} %`;
}

// Frames of which the world has nothing.
export function lossText({ dropped_count, refused_count }: Sensor): string {
  const refused = Number(refused_count) > 0 ? `, ${count(refused_count)} refused` : "";
  return `${count(dropped_count)} dropped${refused}`;
}

export function ageText(age_s: number): string {
  if (age_s < 1) return "now";
  if (age_s < 120) return `${fixed(age_s, 0)} s ago`;
  return age_s < 7200 ? `${fixed(age_s / 60, 0)} min ago` : `${fixed(age_s / 3600, 0)} h ago`;
}

// Reasons to look at the sensor's calibration: the newest contradiction, and a pose that objects at
// rest suggest. Empty if there are none.
export function calibrationText({ conflicts, estimate }: Sensor): string {
  const conflict = conflicts.at(-1);
  if (conflict !== undefined) return conflict;
  if (!estimate) return "";
  return `pose off by ${mm(estimate.translation_error_m)} mm, ${degrees(estimate.rotation_error_rad)}°`;
}

export const latencySum = ({ server_ms, way_ms, page_ms }: LatencyParts): string =>
  `Picture ${fixed(server_ms + way_ms + page_ms, 0)} ms after the frame`;

export const latencyParts = ({ server_ms, way_ms, page_ms }: LatencyParts): string =>
  `Server ${ms(server_ms)} ms, way ${ms(way_ms)} ms, page ${ms(page_ms)} ms: from the last byte of a frame until it is drawn`;
