// The reason why a socket does not open. Browsers hide it from pages, so it is requested from the
// same address.

export interface ConnectionError {
  why: string;      // empty: unknown
  isFinal: boolean; // retrying cannot succeed
  wait_ms: number;  // delay before a retry
}

const unknown: ConnectionError = { why: "", isFinal: false, wait_ms: 0 };

// Interprets the reply to a plain request for the socket.
export function connectionErrorOf(status: number, text: string, retryAfter: string | null): ConnectionError {
  const why = text.trim().slice(0, 300);
  if (status === 403) return { why: why || "the server refuses this page", isFinal: true, wait_ms: 0 };
  if (status === 503) return { why, isFinal: false, wait_ms: 1000 * (Number(retryAfter) || 0) };
  // A WebSocket would be allowed there: a proxy blocks it, or it was refused only at that time.
  if (status === 426) return { why: "the server answers, but its socket does not open", isFinal: false, wait_ms: 0 };
  return { ...unknown, why: `the socket is answered with ${status}` };
}

export async function fetchConnectionError(patience_ms: number): Promise<ConnectionError> {
  const control = new AbortController();
  const overdue = setTimeout(() => control.abort(), patience_ms);
  try {
    const reply = await fetch("/socket", { cache: "no-store", signal: control.signal });
    return connectionErrorOf(reply.status, await reply.text(), reply.headers.get("Retry-After"));
  } catch {
    return unknown;  // nobody answers
  } finally {
    clearTimeout(overdue);
  }
}
