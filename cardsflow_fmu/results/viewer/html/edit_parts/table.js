// Text of `muscles.csv`, as Python writes it, see addin_sdfusion/robot/formats/muscle_table/.

const COLUMNS = ["role", "name", "number", "frame", "link", "x [m]", "y [m]", "z [m]", "f_min [N]", "f_max [N]", "model", "parameters",
  "surface", "side", "turns", "inside", "shape", "radius [m]", "length [m]", "half_axis_y [m]", "half_axis_z [m]", "roll [rad]", "pitch [rad]", "yaw [rad]", "options"];
const ALWAYS = 12; // the first columns are written even if they are empty

// Returns a number as Python's repr writes it.
function numberText(x) {
  if (!Number.isFinite(x)) return x > 0 ? "inf" : x < 0 ? "-inf" : "nan";
  const [digits, exponent] = x.toExponential().split("e"), power = Number(exponent);
  if (x !== 0 && (power < -4 || power >= 16)) return `${digits}e${power < 0 ? "-" : "+"}${String(Math.abs(power)).padStart(2, "0")}`;
  const text = Object.is(x, -0) ? "-0" : String(x);
  return Number.isInteger(x) ? `${text}.0` : text;
}

const cellText = text => /[,"\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
const optional = x => x === null || x === undefined ? "" : numberText(x);
const placeCells = ({ link, position }) => ({ frame: "link", link, "x [m]": numberText(position[0]), "y [m]": numberText(position[1]), "z [m]": numberText(position[2]) });

function muscleTableText({ muscles, wraps }) {
  const rows = [...muscles.flatMap(muscleRows), ...wraps.map(surfaceRow)];
  const used = COLUMNS.filter((column, i) => i < ALWAYS || rows.some(row => row[column]));
  return [used, ...rows.map(row => used.map(column => row[column] ?? ""))].map(cells => `${cells.map(cellText).join(",")}\n`).join("");
}

function muscleRows({ name, law, parameters, f_min, f_max, points, wraps, options = "" }) {
  const settings = { "f_min [N]": numberText(f_min), "f_max [N]": numberText(f_max ?? Infinity), model: law,
    parameters: Object.entries(parameters).map(([key, value]) => `${key}=${numberText(value)}`).join(" ") };
  const first = options || !points.length ? [{ role: "via", name, ...settings, options }] : [];
  return [
    ...first,
    ...points.map((point, k) => ({ role: "via", name, number: String(k), ...placeCells(point), ...(k || first.length ? {} : settings), options: point.options ?? "" })),
    ...wraps.map(({ surface, segment, side = 0, turns = 0, inside = false, options: more = "" }) => ({ role: "wrap", name, number: String(segment), surface,
      side: side ? String(side) : "", turns: turns ? String(turns) : "", inside: inside ? "yes" : "", options: more })),
  ];
}

function surfaceRow(wrap) {
  const { name, shape, radius, length, half_axes, rpy } = wrap, isTurned = rpy.some(angle => angle !== 0);
  return {
    role: "surface", name, ...placeCells(wrap), shape, "radius [m]": numberText(radius), "length [m]": optional(length),
    "half_axis_y [m]": optional(half_axes?.[0]), "half_axis_z [m]": optional(half_axes?.[1]),
    ...(isTurned ? { "roll [rad]": numberText(rpy[0]), "pitch [rad]": numberText(rpy[1]), "yaw [rad]": numberText(rpy[2]) } : {}),
  };
}
