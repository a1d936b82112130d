// The distance over the steps, as SVG, with a cursor.

const SVG = 'http://www.w3.org/2000/svg';

function svgElement(name, attributes, parent) {
  const element = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (parent) parent.append(element);
  return element;
}

class Curve {
  constructor(holder) {
    this.holder = holder;
  }

  // points: [x, distance] pairs.
  show(points, label) {
    this.points = points;
    this.holder.replaceChildren();
    this.cursor = null;
    if (points.length === 0) {
      this.holder.textContent = 'nothing was recorded';
      return;
    }
    const [width, height, left, bottom, top] = [420, 220, 44, 34, 12];
    const svg = svgElement('svg', { viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': label }, this.holder);
    const last = Math.max(1, points[points.length - 1][0]);
    const highest = Math.max(...points.map((point) => point[1])) * 1.08 || 1;
    this.x = (value) => left + (width - left - 12) * value / last;
    this.y = (value) => height - bottom - (height - bottom - top) * value / highest;
    for (const share of [0, 0.5, 1]) {
      const value = highest * share / 1.08;
      svgElement('line', { class: 'axis', x1: left, x2: width - 12, y1: this.y(value), y2: this.y(value) }, svg);
      svgElement('text', { x: left - 6, y: this.y(value) + 4, 'text-anchor': 'end' }, svg).textContent = value.toFixed(2);
    }
    for (const value of new Set([0, Math.round(last / 2), Math.round(last)])) {
      svgElement('text', { x: this.x(value), y: height - bottom + 16, 'text-anchor': 'middle' }, svg).textContent = value;
    }
    svgElement('text', { x: (width + left) / 2, y: height - 3, 'text-anchor': 'middle' }, svg).textContent = label;
    const path = points.map((point) => `${this.x(point[0]).toFixed(1)} ${this.y(point[1]).toFixed(1)}`).join(' L ');
    svgElement('path', { class: 'area', d: `M ${this.x(points[0][0])} ${this.y(0)} L ${path} L ${this.x(points[points.length - 1][0])} ${this.y(0)} Z` }, svg);
    svgElement('path', { class: 'line', d: `M ${path}` }, svg);
    this.svg = svg;
    this.span = { y1: top, y2: height - bottom };
  }

  point(x) {
    const points = this.points;
    if (points.length === 0) return;
    if (!this.cursor) {
      this.cursor = svgElement('line', { class: 'cursor', ...this.span }, this.svg);
      this.dot = svgElement('circle', { r: 4.5 }, this.svg);
    }
    let idx = points.findIndex((point) => point[0] >= x);
    if (idx < 0) idx = points.length - 1;
    const before = points[Math.max(0, idx - 1)];
    const span = points[idx][0] - before[0];
    const share = span > 0 ? Math.min(1, Math.max(0, (x - before[0]) / span)) : 1;
    const y = before[1] + share * (points[idx][1] - before[1]);
    this.cursor.setAttribute('x1', this.x(x));
    this.cursor.setAttribute('x2', this.x(x));
    this.dot.setAttribute('cx', this.x(x));
    this.dot.setAttribute('cy', this.y(y));
  }
}
