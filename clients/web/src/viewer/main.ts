// Lists the objects of the world "default".
export {};
const call = "cwm.v1.WorldService/ListObjects";

// The fields of a protobuf message whose values are bytes, by number.
function* fields(bytes: Uint8Array): Generator<[number, Uint8Array]> {
  let at = 0;
  const varint = (): number => {
    let value = 0;
    for (let shift = 0; ; shift += 7) {
      const byte = bytes[at++] ?? 0;
      value += (byte & 127) * 2 ** shift;
      if (byte < 128) return value;
    }
  };
  while (at < bytes.length) {
    const tag = varint();
    if (tag % 8 === 0) varint();
    else if (tag % 8 === 1) at += 8;
    else if (tag % 8 === 5) at += 4;
    else {
      const length = varint();
      yield [tag >> 3, bytes.subarray(at, at + length)];
      at += length;
    }
  }
}

const text = new TextDecoder();
const list = document.body.appendChild(document.createElement("ul"));
const socket = new WebSocket(`ws://${location.host}/socket`);
socket.binaryType = "arraybuffer";
socket.onopen = () => {
  const method = new TextEncoder().encode(call);
  socket.send(new Uint8Array([8, 1, 18, method.length + 2, 10, method.length, ...method]));
};
socket.onmessage = (event) => {
  for (const [number, message] of fields(new Uint8Array(event.data as ArrayBuffer))) {
    if (number !== 2) continue;
    for (const [what, object] of fields(message)) {
      if (what !== 3) continue;
      for (const [field, name] of fields(object)) {
        if (field === 1) list.appendChild(document.createElement("li")).textContent = text.decode(name);
      }
    }
  }
};
