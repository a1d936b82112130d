// Objects in 3-D: their shapes are fetched once and drawn by a Viewer.

const COLOURS = { base: [0.27, 0.47, 0.69], relative: [0.93, 0.49, 0.13], other: [0.55, 0.58, 0.64] };
const GHOST_ALPHA = 0.3;
const MAX_SURFACES = 200;

class Surfaces {
  constructor() {
    this.known = new Map();
    this.onLoad = () => {};
  }

  // The shape of a key, or null until it is there.
  get(key) {
    if (!this.known.has(key)) {
      this.known.set(key, null);
      while (this.known.size > MAX_SURFACES) this.known.delete(this.known.keys().next().value);
      fetch(`model/${key}`)
        .then((answer) => (answer.ok ? answer.json() : Promise.reject(new Error(answer.statusText))))
        .then((model) => { this.known.set(key, surfaceOf(model)); this.onLoad(); })
        .catch(() => this.known.delete(key));
    }
    return this.known.get(key);
  }
}

// A canvas with objects; where there is no WebGL, words instead.
class SceneView {
  constructor(canvas, surfaces) {
    this.surfaces = surfaces;
    this.framed = '';
    try {
      this.viewer = new Viewer(canvas);
    } catch (error) {
      this.viewer = null;
      const words = document.createElement('div');
      words.className = 'failed';
      words.textContent = `3-D is not available in this browser (${error.message}).`;
      canvas.replaceWith(words);
    }
  }

  // objects: {model, pose, role, alpha}; frame: objects that must be in sight. A new name frames anew.
  show(objects, table, frame, name) {
    if (!this.viewer) return;
    const drawn = objects.filter((object) => object.model && this.surfaces.get(object.model));
    const framing = frame.filter((object) => object.model);
    if (framing.length && this.framed !== name && framing.every((object) => this.surfaces.get(object.model))) {
      this.framed = name;
      this.viewer.frame(framing.flatMap((object) => cornersOf(this.surfaces.get(object.model), object.pose)));
    }
    const items = drawn.map(({ model, pose, role, alpha }) => ({
      mesh: this.viewer.mesh(model, this.surfaces.get(model)), pose, alpha, colour: COLOURS[role] || COLOURS.other,
    }));
    this.viewer.keep(new Set(drawn.map((object) => object.model)));
    this.viewer.show(items, table);
  }
}

// Corners of the box around an object, in the world.
function cornersOf(surface, pose) {
  const [low, high] = boxOf(surface);
  const matrix = matrixOfPose(pose);
  return [0, 1, 2, 3, 4, 5, 6, 7].map((bits) => transformed(matrix, [0, 1, 2].map((axis) => (bits >> axis & 1 ? high : low)[axis])));
}

function boxOf(surface) {
  if (!surface.box) {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    surface.positions.forEach((value, idx) => {
      low[idx % 3] = Math.min(low[idx % 3], value);
      high[idx % 3] = Math.max(high[idx % 3], value);
    });
    surface.box = [low, high];
  }
  return surface.box;
}
