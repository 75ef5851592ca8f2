// Why a socket does not open. A browser tells a page nothing of it; the same address asked by a plain request says it.

export interface Refusal {
  why: string;      // empty: nothing was said
  isFinal: boolean; // asking again changes nothing
  wait_ms: number;  // before it is worth asking again
}

const unknown: Refusal = { why: "", isFinal: false, wait_ms: 0 };

// Of the reply to a plain request for the socket.
export function refusalOf(status: number, text: string, retryAfter: string | null): Refusal {
  const why = text.trim().slice(0, 300);
  if (status === 403) return { why: why || "the server refuses this page", isFinal: true, wait_ms: 0 };
  if (status === 503) return { why, isFinal: false, wait_ms: 1000 * (Number(retryAfter) || 0) };
  // There it would have asked for a WebSocket: what is between lets none through, or it was refused just then.
  if (status === 426) return { why: "the server answers, but its socket does not open", isFinal: false, wait_ms: 0 };
  return { ...unknown, why: `the socket is answered with ${status}` };
}

export async function askWhy(patience_ms: number): Promise<Refusal> {
  const control = new AbortController();
  const overdue = setTimeout(() => control.abort(), patience_ms);
  try {
    const reply = await fetch("/socket", { cache: "no-store", signal: control.signal });
    return refusalOf(reply.status, await reply.text(), reply.headers.get("Retry-After"));
  } catch {
    return unknown;  // nobody is there
  } finally {
    clearTimeout(overdue);
  }
}
