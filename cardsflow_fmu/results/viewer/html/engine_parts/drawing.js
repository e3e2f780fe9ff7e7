// Poses of links at the state of the plant.

class Drawing {
  constructor(plant, tables, part) {
    this.plant = plant;
    const integers = name => new Int32Array(part(tables[name]).slice().buffer);
    const reals = name => new Float64Array(part(tables[name]).slice().buffer);
    for (const name of ["frames", "wrenched"]) this[name] = integers(name);
    this.places = reals("places");
    this.links = tables.links;
    this.poses = new Float32Array(12 * this.links.length);
  }

  // Returns rotation, row by row, and position of a link in the world.
  pose(link, into = new Float64Array(12), at = 0) {
    const frame = this.frames[link], local = this.places.subarray(12 * link, 12 * link + 12);
    if (frame < 0) {
      into.set(local, at);
      return into;
    }
    const R = this.plant.array("frame_rotation").subarray(9 * frame, 9 * frame + 9);
    const o = this.plant.array("frame_origin").subarray(3 * frame, 3 * frame + 3);
    for (let i = 0; i < 3; i++) {
      for (let j = 0; j < 3; j++)
        into[at + 3 * i + j] = R[3 * i] * local[j] + R[3 * i + 1] * local[3 + j] + R[3 * i + 2] * local[6 + j];
      into[at + 9 + i] = o[i] + R[3 * i] * local[9] + R[3 * i + 1] * local[10] + R[3 * i + 2] * local[11];
    }
    return into;
  }

  allPoses() {
    for (let link = 0; link < this.links.length; link++) this.pose(link, this.poses, 12 * link);
    return this.poses;
  }
}

const dot3 = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross3 = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
