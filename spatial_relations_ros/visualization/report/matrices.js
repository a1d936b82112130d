// 4 x 4 matrices, column-major as WebGL takes them; poses are [x, y, z, qw, qx, qy, qz].

function multiply(a, b) {
  const out = new Float32Array(16);
  for (let column = 0; column < 4; column++) {
    for (let row = 0; row < 4; row++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += a[k * 4 + row] * b[column * 4 + k];
      out[column * 4 + row] = sum;
    }
  }
  return out;
}

function perspective(fieldOfView, aspect, near, far) {
  const f = 1 / Math.tan(fieldOfView / 2);
  const depth = near - far;
  return new Float32Array([
    f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / depth, -1, 0, 0, 2 * far * near / depth, 0,
  ]);
}

function lookAt(eye, target) {
  const back = normalized([eye[0] - target[0], eye[1] - target[1], eye[2] - target[2]]);
  const right = normalized(cross([0, 0, 1], back));
  const up = cross(back, right);
  return new Float32Array([
    right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
    -dot(right, eye), -dot(up, eye), -dot(back, eye), 1,
  ]);
}

function matrixOfPose(pose) {
  const [x, y, z, w, i, j, k] = pose;
  return new Float32Array([
    1 - 2 * (j * j + k * k), 2 * (i * j + w * k), 2 * (i * k - w * j), 0,
    2 * (i * j - w * k), 1 - 2 * (i * i + k * k), 2 * (j * k + w * i), 0,
    2 * (i * k + w * j), 2 * (j * k - w * i), 1 - 2 * (i * i + j * j), 0,
    x, y, z, 1,
  ]);
}

// A straight line and the shorter turn.
function poseBetween(start, end, share) {
  const pose = [0, 1, 2].map((axis) => start[axis] + share * (end[axis] - start[axis]));
  let cosine = 0;
  for (let idx = 3; idx < 7; idx++) cosine += start[idx] * end[idx];
  const sign = cosine < 0 ? -1 : 1;
  const angle = Math.acos(Math.min(1, Math.abs(cosine)));
  let first = 1 - share;
  let second = share;
  if (angle > 1e-6) {
    first = Math.sin((1 - share) * angle) / Math.sin(angle);
    second = Math.sin(share * angle) / Math.sin(angle);
  }
  const quat = [3, 4, 5, 6].map((idx) => first * start[idx] + second * sign * end[idx]);
  const norm = Math.hypot(...quat);
  return pose.concat(quat.map((value) => value / norm));
}

function transformed(matrix, point) {
  return [0, 1, 2].map((row) => matrix[row] * point[0] + matrix[4 + row] * point[1]
    + matrix[8 + row] * point[2] + matrix[12 + row]);
}

function dot(a, b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function normalized(a) {
  const length = Math.hypot(...a) || 1;
  return a.map((value) => value / length);
}
