// Files of the experiment with the live changes, as a ZIP archive.

// Returns bytes of the archive. `changes` are numbers by keys of `cardsflow run --set`.
async function archiveOf(text, data, setup, changes) {
  const packed = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const contents = JSON.parse(await new Response(stream).text()), decoder = new TextDecoder("utf-8", { fatal: true });
  const files = Object.entries(contents).map(([name, base64]) => [name, Uint8Array.from(atob(base64), c => c.charCodeAt(0))]);
  const file = files.find(([name]) => name === data.experimentFile), experiment = JSON.parse(decoder.decode(file[1]));
  for (const [key, value] of Object.entries(changes)) applyChange(experiment, data, setup, key, value);
  file[1] = new TextEncoder().encode(JSON.stringify(experiment, null, 1));
  return zip(files);
}

// Returns the coordinates or tasks with gains of the experiment's controller.
const gainNames = (data, setup) => setup.space === "task" ? data.tasks : setup.coordinates.map(c => c.name);

// Writes a changed number into the settings, in which numbers of links, muscles and joints are lists.
function applyChange(experiment, data, setup, key, value) {
  const lists = {
    "plant.mass_scale": setup.links, "plant.friction_scale": setup.muscles.map(muscle => muscle.name),
    "plant.tension_scale": setup.muscles.map(muscle => muscle.name), "plant.break_time": setup.muscles.map(muscle => muscle.name),
  };
  for (const gain of ["kp", "kd"]) lists[`controller.${gain}`] = gainNames(data, setup);
  if (key === "robot.gravity") {
    for (const robot of experiment.robots || [experiment.robot]) robot.gravity = value;
    return;
  }
  const limit = /^muscles\.(.+)\.f_max$/.exec(key);
  if (limit && experiment.muscles[limit[1]]) {
    experiment.muscles[limit[1]].f_max = value;
    return;
  }
  const list = Object.keys(lists).find(name => key.startsWith(`${name}.`)), [table, entry] = list ? list.split(".") : [];
  const at = list ? lists[list].indexOf(key.slice(list.length + 1)) : -1, numbers = list && experiment[table][entry];
  if (at < 0 || !Array.isArray(numbers) || numbers.length !== lists[list].length)
    throw new Error(`${key}: the experiment has no such setting; reset this change`);
  numbers[at] = value;
}

// Returns a ZIP archive of [name, bytes] without compression.
function zip(files) {
  const parts = [], directory = [];
  let size = 0;
  const record = (signature, numbers) => {
    const bytes = new Uint8Array(4 + numbers.reduce((sum, [width]) => sum + width, 0)), view = new DataView(bytes.buffer);
    view.setUint32(0, signature, true);
    let at = 4;
    for (const [width, number] of numbers) {
      if (width === 2) view.setUint16(at, number, true);
      else view.setUint32(at, number, true);
      at += width;
    }
    return bytes;
  };
  for (const [name, bytes] of files) {
    const title = new TextEncoder().encode(name), length = bytes.length;
    // version, flags (UTF-8), method, time, date (1980-01-01), checksum, sizes, length of name, of extra fields
    const common = [[2, 20], [2, 0x800], [2, 0], [2, 0], [2, 33], [4, crc32(bytes)], [4, length], [4, length], [2, title.length], [2, 0]];
    directory.push(record(0x02014b50, [[2, 20], ...common, [2, 0], [2, 0], [2, 0], [4, 0], [4, size]]), title);
    const local = [record(0x04034b50, common), title, bytes];
    parts.push(...local);
    size += local.reduce((sum, part) => sum + part.length, 0);
  }
  const listed = directory.reduce((sum, part) => sum + part.length, 0);
  const end = record(0x06054b50, [[2, 0], [2, 0], [2, files.length], [2, files.length], [4, listed], [4, size], [2, 0]]);
  return new Blob([...parts, ...directory, end], { type: "application/zip" });
}
