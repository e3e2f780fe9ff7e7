// Moment arms, torque ranges, and the joint that lacks torque.

// Variables have the largest number instead of infinity.
const unlimited = force => force < 1e300 ? force : Infinity;

class Analysis {
  constructor(engine) { this.engine = engine; }

  // Returns moment arms, in m or without unit, and lengths of a muscle over the range of a joint.
  momentArms(muscle, joint, count = 61) {
    const { engine } = this, { plant, header } = engine, { lower, upper } = header.coordinates[joint];
    const n = header.coordinates.length, pose = plant.group("q").slice(), now = pose[joint];
    if (!this.robot) this.robot = new Model(engine.module, header.models[0], engine.changes.files[0], plant.ports);
    const state = plant.state();
    const low = finiteOr(lower, now - Math.PI), high = finiteOr(upper, now + Math.PI);
    const q = Array.from({ length: count }, (_, i) => low + (high - low) * i / (count - 1));
    const lengths = [], arms = q.map(value => {
      pose[joint] = value;
      writePose(state, pose);
      this.robot.setState(state);
      lengths.push(this.robot.array("lengths")[muscle]);
      return -this.robot.array("jacobian")[n * muscle + joint];
    });
    return { q, arms, lengths };
  }

  // Returns minimum and maximum torque of each joint that the force limits allow at the current pose.
  torqueRange() {
    const { plant, header, controller } = this.engine, n = header.coordinates.length;
    const L = plant.array("jacobian"), scales = plant.array("tension_scale"), ranges = new Float64Array(2 * n);
    const low = controller && controller.group("f_min"), high = controller && controller.group("f_max");
    header.muscles.forEach(({ f_min, f_max }, i) => {
      const a = scales[i] * (low ? low[i] : f_min), b = scales[i] && scales[i] * unlimited(high ? high[i] : finiteOr(f_max, Infinity));
      for (let j = 0; j < n; j++) {
        const arm = -L[n * i + j];
        if (arm === 0) continue;
        ranges[2 * j] += arm > 0 ? arm * a : arm * b;
        ranges[2 * j + 1] += arm > 0 ? arm * b : arm * a;
      }
    });
    return ranges;
  }

  // Returns the joint, or task coordinate, with the largest shortfall, or null.
  shortfall() {
    const { controller } = this.engine, slack = controller ? controller.group("slack") : [];
    let worst = -1;
    slack.forEach((value, i) => { if (worst < 0 || Math.abs(value) > Math.abs(slack[worst])) worst = i; });
    if (worst < 0) return null;
    const port = controller.entry.groups.slack[0] + worst;
    return { name: controller.entry.names[port].slice("slack.".length), value: slack[worst], unit: controller.entry.units[port] };
  }
}
