// Decodes the motion in the page; page_data.py defines the format.

async function unpack(text) {
  const packed = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const length = new DataView(bytes.buffer).getUint32(0, true);
  const motion = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
  const tables = bytes.subarray(4 + length);
  for (const act of motion.acts) {
    for (const name of Object.keys(act.signals)) act.signals[name] = decodeTable(tables, act.signals[name]);
    for (const shape of act.shapes)
      for (const name of ["points", "colours", "values", "vertices", "faces"])
        if (shape[name]) shape[name] = decodeTable(tables, shape[name]);
  }
  return motion;
}

// Decodes a table to { rows, columns, numbers }, with numbers row by row.
function decodeTable(bytes, { at, rows, columns, low, high }) {
  const size = bytes.length / 2, numbers = new Float32Array(rows * columns);
  const unit = (high - low) / 65535;
  for (let column = 0; column < columns; column++) {
    let level = 0;
    for (let row = 0; row < rows; row++) {
      const place = at + column * rows + row;
      level = (level + bytes[place] + 256 * bytes[size + place]) & 65535;
      numbers[row * columns + column] = low + level * unit;
    }
  }
  return { rows, columns, numbers };
}

// Interpolates a row between frames k and k + 1; `part` is from 0 to 1.
function rowAt(table, k, part, into) {
  const { rows, columns, numbers } = table;
  const a = Math.min(k, rows - 1) * columns, b = Math.min(k + 1, rows - 1) * columns;
  for (let i = 0; i < columns; i++) into[i] = numbers[a + i] + part * (numbers[b + i] - numbers[a + i]);
  return into;
}
