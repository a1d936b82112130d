// A view of objects on a table, in WebGL 2.

const CREASE_COSINE = Math.cos(0.66);

const VERTEX_SHADER = `#version 300 es
in vec3 position; in vec3 normal;
uniform mat4 projection, world; uniform float pointSize;
out vec3 place, facing;
void main() {
  vec4 p = world * vec4(position, 1.0);
  place = p.xyz; facing = mat3(world) * normal;
  gl_Position = projection * p;
  gl_PointSize = pointSize / gl_Position.w;
}`;

const FRAGMENT_SHADER = `#version 300 es
precision highp float;
in vec3 place, facing;
uniform vec3 colour, eye, light, ground; uniform float alpha; uniform int mode; uniform vec4 table;
out vec4 shown;
void main() {
  if (mode == 1) {
    // The table: fading, with lines every 10 cm; they fade where they would flicker.
    float far = smoothstep(0.35, 1.0, distance(place.xy, table.xy) / table.w);
    vec2 cell = place.xy * 10.0;
    vec2 width = fwidth(cell);
    vec2 near = abs(fract(cell - 0.5) - 0.5) / width;
    float line = (1.0 - min(min(near.x, near.y), 1.0)) * (1.0 - smoothstep(0.2, 0.6, max(width.x, width.y)));
    shown = vec4(mix(ground, colour, line), 1.0 - far);
    return;
  }
  if (mode == 2) { shown = vec4(0.0, 0.0, 0.0, alpha); return; }
  vec3 view = normalize(eye - place);
  vec3 n;
  if (mode == 3) {
    vec2 c = gl_PointCoord * 2.0 - 1.0;
    if (dot(c, c) > 1.0) discard;
    n = normalize(vec3(c.x, -c.y, 1.0));
    n = n.z * view + n.y * vec3(0.0, 0.0, 1.0) + n.x * cross(vec3(0.0, 0.0, 1.0), view);
  } else {
    n = normalize(facing);
    if (!gl_FrontFacing) n = -n;
  }
  n = normalize(n);
  float sun = max(dot(n, light), 0.0);
  float sky = 0.5 + 0.5 * n.z;
  float shine = pow(max(dot(n, normalize(light + view)), 0.0), 32.0);
  vec3 lit = colour * (0.38 + 0.27 * sky + 0.5 * sun) + 0.1 * shine;
  float rim = 1.0 - abs(dot(n, view));
  shown = vec4(lit, alpha < 1.0 ? alpha * (0.5 + rim) : 1.0);
}`;

function integers(text, Type) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Type(bytes.buffer);
}

// Corner positions and normals: smooth over shallow edges, sharp over creases.
function surfaceOf(model) {
  const levels = integers(model.positions, Uint16Array);
  const places = new Float32Array(levels.length);
  for (let idx = 0; idx < levels.length; idx++) places[idx] = model.low[idx % 3] + model.step * levels[idx];
  if (!model.triangles) return { positions: places, normals: new Float32Array(places.length), isCloud: true };
  const corners = integers(model.triangles, model.wide ? Uint32Array : Uint16Array);
  const at = (corner) => [places[3 * corner], places[3 * corner + 1], places[3 * corner + 2]];
  const areas = [];
  const around = new Map();
  for (let face = 0; face < corners.length / 3; face++) {
    const [a, b, c] = [0, 1, 2].map((idx) => at(corners[3 * face + idx]));
    areas.push(cross([b[0] - a[0], b[1] - a[1], b[2] - a[2]], [c[0] - a[0], c[1] - a[1], c[2] - a[2]]));
    for (let idx = 0; idx < 3; idx++) {
      const corner = corners[3 * face + idx];
      if (!around.has(corner)) around.set(corner, []);
      around.get(corner).push(face);
    }
  }
  const units = areas.map(normalized);
  const positions = new Float32Array(3 * corners.length);
  const normals = new Float32Array(3 * corners.length);
  for (let idx = 0; idx < corners.length; idx++) {
    const own = units[Math.floor(idx / 3)];
    const sum = [0, 0, 0];
    for (const face of around.get(corners[idx])) {
      if (dot(units[face], own) > CREASE_COSINE) for (let axis = 0; axis < 3; axis++) sum[axis] += areas[face][axis];
    }
    positions.set(at(corners[idx]), 3 * idx);
    normals.set(normalized(sum), 3 * idx);
  }
  return { positions, normals, isCloud: false };
}

class Viewer {
  constructor(canvas) {
    this.canvas = canvas;
    this.items = [];
    this.table = 0;
    this.home = { azimuth: -0.9, elevation: 0.5 };
    this.camera = { ...this.home, target: [0, 0, 0], radius: 1, zoom: 1 };
    this.gl = canvas.getContext('webgl2', { antialias: true, alpha: true, premultipliedAlpha: true, preserveDrawingBuffer: true, stencil: true });
    if (!this.gl) throw new Error('no WebGL 2');
    this.program = this.link();
    this.meshes = new Map();
    this.square = this.upload({ positions: new Float32Array([-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0]), normals: new Float32Array(18) });
    this.onTurn = () => {};
    this.onDraw = () => {};
    this.listen();
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  link() {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX_SHADER], [gl.FRAGMENT_SHADER, FRAGMENT_SHADER]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.bindAttribLocation(program, 0, 'position');
    gl.bindAttribLocation(program, 1, 'normal');
    gl.linkProgram(program);
    this.uniforms = {};
    for (const name of ['projection', 'world', 'pointSize', 'colour', 'eye', 'light', 'ground', 'alpha', 'mode', 'table']) {
      this.uniforms[name] = gl.getUniformLocation(program, name);
    }
    return program;
  }

  upload(surface) {
    const gl = this.gl;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const buffers = [surface.positions, surface.normals].map((values, idx) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(idx);
      gl.vertexAttribPointer(idx, 3, gl.FLOAT, false, 0, 0);
      return buffer;
    });
    return { array, buffers, count: surface.positions.length / 3, isCloud: surface.isCloud };
  }

  mesh(key, surface) {
    if (!this.meshes.has(key)) this.meshes.set(key, this.upload(surface));
    return this.meshes.get(key);
  }

  // Frees all meshes but those of these keys.
  keep(keys) {
    for (const [key, mesh] of this.meshes) {
      if (keys.has(key)) continue;
      this.gl.deleteVertexArray(mesh.array);
      mesh.buffers.forEach((buffer) => this.gl.deleteBuffer(buffer));
      this.meshes.delete(key);
    }
  }

  // Where a point of the world was drawn last, CSS pixels from the canvas's upper left corner.
  place(point) {
    const [x, y, , w] = [0, 1, 2, 3].map((row) => point.reduce((sum, value, axis) => sum + this.projection[4 * axis + row] * value, this.projection[12 + row]));
    return [(x / w + 1) / 2 * this.canvas.clientWidth, (1 - y / w) / 2 * this.canvas.clientHeight];
  }

  // Frames boxes of points once; turning does not change what is framed.
  frame(points) {
    const low = [0, 1, 2].map((axis) => Math.min(...points.map((point) => point[axis])));
    const high = [0, 1, 2].map((axis) => Math.max(...points.map((point) => point[axis])));
    this.camera.target = low.map((value, axis) => (value + high[axis]) / 2);
    this.camera.radius = Math.max(0.02, 0.5 * Math.hypot(...low.map((value, axis) => high[axis] - value)));
    this.draw();
  }

  // items: {mesh, pose, colour, alpha}
  show(items, table) {
    this.items = items;
    this.table = table;
    this.draw();
  }

  listen() {
    const pointers = new Map();
    let spread = 0;
    const turned = () => { this.draw(); this.onTurn(this.camera); };
    this.canvas.addEventListener('pointerdown', (event) => {
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      this.canvas.setPointerCapture(event.pointerId);
      spread = 0;
    });
    this.canvas.addEventListener('pointermove', (event) => {
      const last = pointers.get(event.pointerId);
      if (!last) return;
      pointers.set(event.pointerId, [event.clientX, event.clientY]);
      if (pointers.size === 2) {
        const [a, b] = [...pointers.values()];
        const now = Math.hypot(a[0] - b[0], a[1] - b[1]);
        if (spread) this.zoomBy(spread / now);
        spread = now;
      } else {
        this.camera.azimuth -= (event.clientX - last[0]) * 0.008;
        this.tilt((event.clientY - last[1]) * 0.008);
      }
      turned();
    });
    const release = (event) => { pointers.delete(event.pointerId); spread = 0; };
    this.canvas.addEventListener('pointerup', release);
    this.canvas.addEventListener('pointercancel', release);
    this.canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.zoomBy(Math.exp(event.deltaY * 0.001));
      turned();
    }, { passive: false });
    this.canvas.addEventListener('dblclick', () => {
      Object.assign(this.camera, { ...this.home, zoom: 1 });
      turned();
    });
    this.canvas.addEventListener('keydown', (event) => {
      const turns = { ArrowLeft: [0.15, 0], ArrowRight: [-0.15, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
      if (event.key in turns) {
        this.camera.azimuth += turns[event.key][0];
        this.tilt(turns[event.key][1]);
      } else if (event.key === '+' || event.key === '-') {
        this.zoomBy(event.key === '+' ? 0.9 : 1.1);
      } else return;
      event.preventDefault();
      turned();
    });
  }

  // Looks from the side of a place in the world, and comes back there when one starts over.
  standAt(eye) {
    const [x, y, z] = eye.map((value, axis) => value - this.camera.target[axis]);
    this.home = { azimuth: Math.atan2(y, x), elevation: Math.min(1.5, Math.max(-0.3, Math.atan2(z, Math.hypot(x, y)))) };
    Object.assign(this.camera, this.home);
    this.draw();
  }

  tilt(angle) { this.camera.elevation = Math.min(1.5, Math.max(-0.3, this.camera.elevation + angle)); }

  zoomBy(factor) { this.camera.zoom = Math.min(6, Math.max(0.15, this.camera.zoom * factor)); }

  draw() {
    const { gl, camera, uniforms } = this;
    const scale = Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.max(1, Math.round(this.canvas.clientWidth * scale));
    const height = Math.max(1, Math.round(this.canvas.clientHeight * scale));
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    const style = getComputedStyle(document.documentElement);
    const [paper, line] = ['--panel', '--line'].map((name) => rgb(style.getPropertyValue(name)));
    gl.viewport(0, 0, width, height);
    gl.clearColor(...paper, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT | gl.STENCIL_BUFFER_BIT);
    const aspect = width / height;
    const fieldOfView = 0.6;
    const away = camera.zoom * camera.radius / Math.sin(fieldOfView / 2) / Math.min(1, aspect);
    const { azimuth, elevation } = camera;
    const eye = [Math.cos(elevation) * Math.cos(azimuth), Math.cos(elevation) * Math.sin(azimuth), Math.sin(elevation)]
      .map((value, axis) => camera.target[axis] + away * value);
    const far = away + 8 * camera.radius;
    const projection = multiply(perspective(fieldOfView, aspect, 0.02 * away, far), lookAt(eye, camera.target));
    this.projection = projection;
    const light = normalized([Math.cos(azimuth + 0.9) * 0.55, Math.sin(azimuth + 0.9) * 0.55, 1]);
    gl.useProgram(this.program);
    gl.uniformMatrix4fv(uniforms.projection, false, projection);
    gl.uniform3fv(uniforms.eye, eye);
    gl.uniform3fv(uniforms.light, light);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    const solid = this.items.filter((item) => item.alpha === 1);
    const pointSize = height * camera.radius * 0.022 / Math.tan(fieldOfView / 2);
    const paint = (item, world, mode) => {
      gl.uniformMatrix4fv(uniforms.world, false, world);
      gl.uniform1i(uniforms.mode, item.mesh.isCloud && mode === 0 ? 3 : mode);
      gl.uniform1f(uniforms.pointSize, pointSize);
      gl.bindVertexArray(item.mesh.array);
      gl.drawArrays(item.mesh.isCloud ? gl.POINTS : gl.TRIANGLES, 0, item.mesh.count);
    };
    // The table from above only, so that one can look at things from below.
    if (eye[2] > this.table) {
      const size = 4 * camera.radius;
      gl.uniform3fv(uniforms.colour, line);
      gl.uniform3fv(uniforms.ground, paper.map((value) => value * 0.965));
      gl.uniform4f(uniforms.table, camera.target[0], camera.target[1], this.table, size);
      gl.depthMask(false);
      paint({ mesh: this.square }, new Float32Array([size, 0, 0, 0, 0, size, 0, 0, 0, 0, 1, 0, camera.target[0], camera.target[1], this.table, 1]), 1);
      // Shadows: everything pressed flat along the light, each pixel darkened once.
      const flat = new Float32Array([1, 0, 0, 0, 0, 1, 0, 0, -light[0] / light[2], -light[1] / light[2], 0, 0,
        this.table * light[0] / light[2], this.table * light[1] / light[2], this.table, 1]);
      gl.enable(gl.STENCIL_TEST);
      gl.stencilFunc(gl.EQUAL, 0, 255);
      gl.stencilOp(gl.KEEP, gl.KEEP, gl.INCR);
      gl.disable(gl.DEPTH_TEST);
      gl.uniform1f(uniforms.alpha, 0.16);
      for (const item of solid) paint(item, multiply(flat, matrixOfPose(item.pose)), 2);
      gl.enable(gl.DEPTH_TEST);
      gl.disable(gl.STENCIL_TEST);
      gl.depthMask(true);
    }
    for (const item of [...solid, ...this.items.filter((other) => other.alpha < 1)]) {
      gl.uniform3fv(uniforms.colour, item.colour);
      gl.uniform1f(uniforms.alpha, item.alpha);
      gl.depthMask(item.alpha === 1);
      paint(item, matrixOfPose(item.pose), 0);
    }
    gl.depthMask(true);
    this.onDraw();
  }
}

function rgb(text) {
  const value = parseInt(text.trim().slice(1), 16);
  return [value >> 16 & 255, value >> 8 & 255, value & 255].map((level) => level / 255);
}
