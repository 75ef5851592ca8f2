// How old the picture is: from the last byte of a sensor's frame at the server until it is
// drawn. Its parts are measured each by one clock: the server's time for the frame, half
// of a call's way there and back, and the page's time from the socket to the drawing. Pure.

export interface LatencyParts { server_ms: number; way_ms: number; page_ms: number; }

// chosen: a number that can be read changes slowly, and one slow picture is none of it; the median of
// so many pictures.
const keptPictures = 15;

// chosen: the least of so many calls, since a busy page takes longer to see an answer, not to get it.
const keptWays = 10;

export class PictureLatency {
  private received_ms: number | undefined;  // of the oldest message whose picture is not begun yet
  private drawing_ms: number | undefined;   // that of the picture being drawn
  private server_ms = 0;
  private pages_ms: number[] = [];
  private ways_ms: number[] = [];

  // A message came that will be drawn.
  received(at_ms: number): void { this.received_ms ??= at_ms; }

  // All that came before is in the picture that is drawn now.
  issued(): void {
    this.drawing_ms ??= this.received_ms;
    this.received_ms = undefined;
  }

  drawn(at_ms: number): void {
    if (this.drawing_ms === undefined) return;
    this.pages_ms = [...this.pages_ms, Math.max(0, at_ms - this.drawing_ms)].slice(-keptPictures);
    this.drawing_ms = undefined;
  }

  // The server's time for a frame, as its sensors report it.
  served(server_ms: number): void { this.server_ms = server_ms; }

  called(thereAndBack_ms: number): void { this.ways_ms = [...this.ways_ms, thereAndBack_ms / 2].slice(-keptWays); }

  reset(): void {
    this.received_ms = this.drawing_ms = undefined;
    this.pages_ms = [];
  }

  // Undefined until something was drawn.
  parts(): LatencyParts | undefined {
    const page_ms = [...this.pages_ms].sort((a, b) => a - b)[Math.floor(this.pages_ms.length / 2)];
    if (page_ms === undefined) return undefined;
    return { server_ms: this.server_ms, way_ms: this.ways_ms.length === 0 ? 0 : Math.min(...this.ways_ms), page_ms };
  }
}
