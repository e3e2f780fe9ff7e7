// Draws bodies, meshes, shadows and the floor with WebGL 2, without a library.

const SHADE = `
  vec3 shade(vec3 colour, vec3 normal, vec3 toEye, vec3 up) {
    vec3 n = normalize(normal), v = normalize(toEye);
    if (dot(n, v) < 0.0) n = -n;
    vec3 key = normalize(v + 0.9 * up + 0.45 * normalize(cross(up, v) + 1e-4));
    float sky = 0.5 + 0.5 * dot(n, up);
    float light = 0.42 + 0.22 * sky + 0.46 * max(dot(n, key), 0.0);
    float gloss = 0.16 * pow(max(dot(n, normalize(key + v)), 0.0), 40.0);
    return colour * light + gloss;
  }`;

const PLACE = `
  uniform mat4 view; uniform vec3 eye, up; uniform float floorHeight, isShadow;
  vec3 projectShadow(vec3 p) { return mix(p, p - up * (dot(p, up) - floorHeight), isShadow); }`;

const BODY_VERTEX = `#version 300 es
  precision highp float; ${PLACE}
  layout(location=0) in vec4 corner; layout(location=1) in vec3 direction;
  layout(location=2) in vec3 a; layout(location=3) in vec3 b;
  layout(location=4) in float radius; layout(location=5) in vec4 colour;
  out vec3 normal, toEye; out vec4 tint;
  void main() {
    vec3 along = b - a; float l = length(along);
    vec3 z = l > 1e-9 ? along / l : vec3(0, 0, 1);
    vec3 x = normalize(cross(abs(z.z) < 0.9 ? vec3(0, 0, 1) : vec3(1, 0, 0), z)), y = cross(z, x);
    vec3 place = projectShadow(a + along * corner.w + radius * (x * corner.x + y * corner.y + z * corner.z));
    normal = x * direction.x + y * direction.y + z * direction.z;
    toEye = eye - place; tint = colour; gl_Position = view * vec4(place, 1);
  }`;

const BODY_PIXEL = `#version 300 es
  precision highp float; uniform vec3 up, shadow; uniform float isShadow;
  in vec3 normal, toEye; in vec4 tint; out vec4 pixel; ${SHADE}
  void main() {
    pixel = isShadow > 0.5 ? vec4(shadow, 1) : vec4(shade(tint.rgb, normal, toEye, up) * tint.a, tint.a);
  }`;

const MESH_VERTEX = `#version 300 es
  precision highp float; ${PLACE}
  layout(location=0) in vec3 corner; uniform mat4 pose; out vec3 place;
  void main() { place = projectShadow((pose * vec4(corner, 1)).xyz); gl_Position = view * vec4(place, 1); }`;

const MESH_PIXEL = `#version 300 es
  precision highp float; uniform vec3 eye, up, colour, shadow; uniform float isShadow;
  in vec3 place; out vec4 pixel; ${SHADE}
  void main() {
    vec3 normal = cross(dFdx(place), dFdy(place));
    pixel = isShadow > 0.5 ? vec4(shadow, 1) : vec4(shade(colour, normal, eye - place, up), 1);
  }`;

const FLOOR_VERTEX = `#version 300 es
  precision highp float; uniform mat4 view; uniform vec3 middle, east, north; uniform float size;
  out vec2 place;
  void main() {
    place = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0 - 1.0; place *= size;
    gl_Position = view * vec4(middle + east * place.x + north * place.y, 1);
  }`;

const FLOOR_PIXEL = `#version 300 es
  precision highp float; uniform float size, cell; in vec2 place; out vec4 pixel;
  void main() {
    vec2 x = place / cell, near = abs(fract(x - 0.5) - 0.5) / fwidth(x);
    float line = 1.0 - min(min(near.x, near.y), 1.0), fade = 1.0 - smoothstep(0.25, 1.0, length(place) / size);
    float alpha = 0.55 * line * fade;
    pixel = vec4(vec3(0.63, 0.68, 0.75) * alpha, alpha);
  }`;

const NUMBERS = 11; // of an instance of a body: both ends, radius, colour, opacity

// Instances of a body that are drawn together. Their memory is used again in each frame.
class Batch {
  constructor(gl, { vertices, elements, count }) {
    this.gl = gl;
    this.size = count;
    this.count = 0;
    this.numbers = new Float32Array(64 * NUMBERS);
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    const attribute = (place, size, stride, offset, every) => {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, gl.FLOAT, false, 4 * stride, 4 * offset);
      gl.vertexAttribDivisor(place, every);
    };
    gl.bindBuffer(gl.ARRAY_BUFFER, vertices);
    attribute(0, 4, 7, 0, 0);
    attribute(1, 3, 7, 4, 0);
    this.instances = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.instances);
    [[2, 3, 0], [3, 3, 3], [4, 1, 6], [5, 4, 7]].forEach(([place, size, offset]) => attribute(place, size, NUMBERS, offset, 1));
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, elements);
    gl.bindVertexArray(null);
  }

  add(points, i, j, radius, colour, alpha) {
    let at = NUMBERS * this.count++;
    if (at === this.numbers.length) {
      const larger = new Float32Array(2 * at);
      larger.set(this.numbers);
      this.numbers = larger;
    }
    const { numbers } = this;
    for (let k = 0; k < 3; k++) numbers[at++] = points[3 * i + k];
    for (let k = 0; k < 3; k++) numbers[at++] = points[3 * j + k];
    numbers[at++] = radius;
    for (let k = 0; k < 3; k++) numbers[at++] = colour[k] / 255;
    numbers[at] = alpha;
  }

  upload() {
    if (!this.count) return;
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, this.instances);
    this.gl.bufferData(this.gl.ARRAY_BUFFER, this.numbers, this.gl.DYNAMIC_DRAW, 0, NUMBERS * this.count);
  }

  draw() {
    if (!this.count) return;
    this.gl.bindVertexArray(this.array);
    this.gl.drawElementsInstanced(this.gl.TRIANGLES, this.size, this.gl.UNSIGNED_SHORT, 0, this.count);
  }
}

const SHADOW = [0.79, 0.82, 0.86], DARK_SHADOW = [0.045, 0.055, 0.07];

class Drawing {
  constructor(canvas) {
    const gl = this.gl = canvas.getContext("webgl2", { antialias: true, alpha: true });
    if (!gl) throw new Error("this browser has no WebGL 2");
    this.canvas = canvas;
    this.dark = DARK;
    this.bodies = this.program(BODY_VERTEX, BODY_PIXEL);
    this.meshes = this.program(MESH_VERTEX, MESH_PIXEL);
    this.floor = this.program(FLOOR_VERTEX, FLOOR_PIXEL);
    const bodies = Object.entries(BODIES).map(([name, body]) => [name, this.body(body)]);
    const batches = () => Object.fromEntries(bodies.map(([name, body]) => [name, new Batch(gl, body)]));
    // with shadow, without shadow, transparent without shadow, and in front of everything
    this.lists = { shadowed: batches(), solid: batches(), clear: batches(), top: batches() };
    this.all = Object.fromEntries(Object.entries(this.lists).map(([name, list]) => [name, Object.values(list)]));
    this.nothing = gl.createVertexArray();
    gl.enable(gl.DEPTH_TEST);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  program(vertex, pixel) {
    const gl = this.gl, program = gl.createProgram(), at = {};
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, pixel]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error("the graphics driver rejects the shaders");
    for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
      const { name } = gl.getActiveUniform(program, i);
      at[name] = gl.getUniformLocation(program, name);
    }
    return { program, at };
  }

  buffer(target, data) {
    const buffer = this.gl.createBuffer();
    this.gl.bindBuffer(target, buffer);
    this.gl.bufferData(target, data, this.gl.STATIC_DRAW);
    return buffer;
  }

  body({ vertices, faces }) {
    const { gl } = this;
    return { vertices: this.buffer(gl.ARRAY_BUFFER, vertices), elements: this.buffer(gl.ELEMENT_ARRAY_BUFFER, faces), count: faces.length };
  }

  mesh(vertices, faces) {
    const gl = this.gl, array = gl.createVertexArray();
    gl.bindVertexArray(array);
    this.buffer(gl.ARRAY_BUFFER, vertices);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    this.buffer(gl.ELEMENT_ARRAY_BUFFER, new Uint16Array(faces));
    gl.bindVertexArray(null);
    return { array, count: faces.length };
  }

  begin() {
    const gl = this.gl, ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.round(this.canvas.clientWidth * ratio), height = Math.round(this.canvas.clientHeight * ratio);
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    gl.disable(gl.SCISSOR_TEST);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  // Removes the instances of all batches, which the next act fills again.
  clearBatches() {
    for (const list of Object.values(this.all)) for (const batch of list) batch.count = 0;
  }

  // Draws act `i` of `count` acts side by side: the batches, and meshes with `pose` and `tint`.
  draw(i, count, camera, world, meshes) {
    const gl = this.gl, width = this.canvas.width / count, { shadowed, solid, clear, top } = this.all;
    gl.viewport(i * width, 0, width, this.canvas.height);
    this.drawFloor(camera, world);
    for (const list of Object.values(this.all)) for (const batch of list) batch.upload();
    const uniforms = { ...camera, up: world.up, floorHeight: world.floorHeight, shadow: this.dark.matches ? DARK_SHADOW : SHADOW };
    this.use(this.meshes, uniforms);
    this.drawMeshes(meshes, 1);
    this.drawMeshes(meshes, 0);
    this.use(this.bodies, uniforms);
    this.castShadows(this.bodies, 1);
    for (const batch of shadowed) batch.draw();
    this.castShadows(this.bodies, 0);
    for (const batch of shadowed) batch.draw();
    for (const batch of solid) batch.draw();
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    for (const batch of clear) batch.draw();
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    if (top.some(batch => batch.count)) {
      gl.clear(gl.DEPTH_BUFFER_BIT); // so that links do not hide handles
      for (const batch of top) batch.draw();
    }
    gl.bindVertexArray(null);
  }

  use({ program, at }, uniforms) {
    const gl = this.gl;
    gl.useProgram(program);
    for (const name in uniforms) {
      const value = uniforms[name];
      if (at[name] === undefined) continue;
      if (typeof value === "number") gl.uniform1f(at[name], value);
      else if (value.length === 3) gl.uniform3fv(at[name], value);
      else gl.uniformMatrix4fv(at[name], false, value);
    }
  }

  // Begins or ends the drawing of shadows, which are in front of the floor.
  castShadows({ at }, isShadow) {
    const { gl } = this;
    gl.uniform1f(at.isShadow, isShadow);
    if (isShadow) gl.enable(gl.POLYGON_OFFSET_FILL);
    else gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(-1, -1);
  }

  drawMeshes(meshes, isShadow) {
    const { gl, meshes: { at } } = this;
    this.castShadows(this.meshes, isShadow);
    for (const { mesh, pose, tint } of meshes) {
      gl.uniformMatrix4fv(at.pose, false, pose);
      gl.uniform3fv(at.colour, tint);
      gl.bindVertexArray(mesh.array);
      gl.drawElements(gl.TRIANGLES, mesh.count, gl.UNSIGNED_SHORT, 0);
    }
  }

  drawFloor(camera, { middle, east, north, reach }) {
    const gl = this.gl;
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    this.use(this.floor, { view: camera.view, middle, east, north, size: 2.2 * reach, cell: 10 ** Math.floor(Math.log10(reach / 2)) });
    gl.bindVertexArray(this.nothing);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }
}
