/* What the page carries inside: the engine and the system's archive, compressed, and texts; and what is read from an archive. */

/* The bytes through a decompressor of the browser. */
async function decompressed(bytes, format) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream(format));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/* The text of the binary part of that name, base64 of a gzip, which an engine takes as it is; nothing where the page has none. */
export const part = (name) => document.getElementById(`part-${name}`)?.textContent.trim();

/* The bytes of such a text. */
export async function unpacked(text) {
  const response = await fetch(`data:application/octet-stream;base64,${text}`);
  return decompressed(await response.arrayBuffer(), "gzip");
}

/* The JSON of that name. */
export const json = (name) => JSON.parse(document.getElementById(name).textContent);

/* Files of a ZIP archive by name: a function that gives the bytes. */
export function archive(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let end = bytes.length - 22;
  while (end >= 0 && view.getUint32(end, true) !== 0x06054b50) end -= 1;
  if (end < 0) throw new Error("This is no ZIP archive, as an FMU or SSP is one: its list of files is missing.");
  const files = new Map();
  let at = view.getUint32(end + 16, true);
  for (let k = view.getUint16(end + 10, true); k > 0; k -= 1) {
    if (at + 46 > bytes.length || view.getUint32(at, true) !== 0x02014b50) throw new Error("The archive's list of files is damaged.");
    const [method, size, local] = [view.getUint16(at + 10, true), view.getUint32(at + 20, true), view.getUint32(at + 42, true)];
    const [name, extra, comment] = [28, 30, 32].map((o) => view.getUint16(at + o, true));
    const path = new TextDecoder().decode(bytes.subarray(at + 46, at + 46 + name)).replaceAll("\\", "/");
    files.set(path, () => {
      const from = local + 30 + view.getUint16(local + 26, true) + view.getUint16(local + 28, true);
      const content = bytes.slice(from, from + size);
      return method === 0 ? Promise.resolve(content) : decompressed(content, "deflate-raw");
    });
    at += 46 + name + extra + comment;
  }
  return files;
}

/* The text of a file of an archive; nothing where it is not there. */
export async function textOf(files, path) {
  const read = files.get(path);
  return read ? new TextDecoder().decode(await read()) : null;
}

/* Has the browser keep the text or bytes as a file. */
export function download(name, content, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([content], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
