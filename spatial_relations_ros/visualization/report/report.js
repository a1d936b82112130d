// The page: what is chosen, and what is shown of it.

const GHOST_ALPHA = 0.3;
const PLAY_SECONDS = 4;

const content = JSON.parse(document.getElementById('data').textContent);
const byId = (id) => document.getElementById(id);
const surfaces = Object.fromEntries(Object.entries(content.models).map(([key, model]) => [key, surfaceOf(model)]));
const state = { caseIdx: 0, answerIdx: 0, at: 0, playing: 0 };
const views = {};
const curve = new Curve(byId('curve'));
const searchCurve = new Curve(byId('search-curve'));

for (const name of ['reference', 'test']) {
  try {
    views[name] = new Viewer(byId(name));
  } catch (error) {
    const words = document.createElement('div');
    words.className = 'failed';
    words.textContent = `3-D is not available in this browser (${error.message}); numbers and curves are below.`;
    byId(name).replaceWith(words);
  }
}
if (views.reference && views.test) {
  const follow = (other) => (camera) => {
    const { azimuth, elevation, zoom } = camera;
    Object.assign(other.camera, { azimuth, elevation, zoom });
    other.draw();
  };
  views.reference.onTurn = follow(views.test);
  views.test.onTurn = follow(views.reference);
}

const chosenCase = () => content.cases[state.caseIdx];
const chosenWay = () => chosenCase().answers[state.answerIdx].way;

// Poses at a place between two moments.
function posesAt(way, at) {
  const idx = Math.min(Math.floor(at), way.length - 2);
  if (idx < 0) return way[0].poses;
  return way[idx].poses.map((pose, object) => poseBetween(pose, way[idx + 1].poses[object], at - idx));
}

function itemsOf(view, objects, poses, alpha) {
  return objects.map((object, idx) => ({
    mesh: view.mesh(object.model, surfaces[object.model]), pose: poses[idx], colour: content.colours[idx], alpha,
  }));
}

// Corners of the boxes around objects, in the world.
function cornersOf(objects, poses) {
  return objects.flatMap((object, idx) => {
    const places = surfaces[object.model].positions;
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    for (let place = 0; place < places.length; place++) {
      low[place % 3] = Math.min(low[place % 3], places[place]);
      high[place % 3] = Math.max(high[place % 3], places[place]);
    }
    const matrix = matrixOfPose(poses[idx]);
    const corners = [];
    for (let bits = 0; bits < 8; bits++) corners.push(transformed(matrix, [0, 1, 2].map((axis) => (bits >> axis & 1 ? high : low)[axis])));
    return corners;
  });
}

function drawScenes() {
  const { reference, test } = chosenCase();
  const way = chosenWay();
  if (views.reference) {
    views.reference.show(itemsOf(views.reference, reference.objects, reference.objects.map((object) => object.pose), 1), reference.table);
  }
  if (views.test) {
    const items = itemsOf(views.test, test.objects, posesAt(way, state.at), 1);
    if (byId('ghosts').checked && state.at > 0) {
      const moved = (idx) => way[0].poses[idx].some((value, part) => Math.abs(value - posesAt(way, state.at)[idx][part]) > 1e-4);
      items.push(...itemsOf(views.test, test.objects, way[0].poses, GHOST_ALPHA).filter((_, idx) => moved(idx)));
    }
    views.test.show(items, test.table);
  }
}

function showMoment() {
  const way = chosenWay();
  const nearest = way[Math.round(state.at)];
  const words = [];
  if (Math.round(state.at) === 0) words.push('before');
  else if (state.at >= way.length - 1) words.push('after');
  else words.push(chosenCase().answers[state.answerIdx].recorded ? `best so far, ${Math.round(state.at)} of ${way.length - 1}, step ${nearest.step}` : 'on the way');
  if (nearest.distance !== null && Math.abs(state.at - Math.round(state.at)) < 0.05) words.push(`distance ${nearest.distance.toFixed(3)}`);
  byId('moment').textContent = words.join(' · ');
  byId('slider').value = state.at;
  byId('slider').setAttribute('aria-valuetext', words.join(', '));
  document.body.dataset.at = state.at.toFixed(2);
  if (way.length > 2 && !byId('moments').hidden) curve.point(state.at);
}

function moveTo(at) {
  state.at = Math.min(chosenWay().length - 1, Math.max(0, at));
  showMoment();
  drawScenes();
}

function cell(row, text, className) {
  const element = row.insertCell();
  element.textContent = text;
  if (className) element.className = className;
  return element;
}

function showTables() {
  const checks = byId('checks');
  checks.replaceChildren();
  for (const [name, value, passed] of chosenCase().answers[state.answerIdx].checks) {
    const row = checks.insertRow();
    cell(row, name);
    cell(row, value);
    cell(row, passed === null ? '' : passed ? '✓' : '✗', `mark ${passed ? 'good' : 'bad'}`).setAttribute('aria-label', passed === null ? '' : passed ? 'passed' : 'failed');
  }
  const facts = byId('facts');
  facts.replaceChildren();
  for (const [name, value] of chosenCase().facts) {
    const row = facts.insertRow();
    cell(row, name);
    cell(row, value);
  }
}

function showCurves() {
  const way = chosenWay();
  const { recorded } = chosenCase().answers[state.answerIdx];
  const moments = way.map((step, idx) => [idx, step.distance]).filter((point) => point[1] !== null);
  byId('moments').hidden = moments.length < 2;
  if (moments.length > 1) curve.show(moments, recorded ? 'changes of the best answer' : 'straight way from before to after');
  const history = chosenCase().history.map((value, idx) => [idx, value]).filter((point) => point[1] !== null);
  byId('search').hidden = history.length < 2;
  byId('distances').hidden = byId('moments').hidden && byId('search').hidden;
  if (history.length > 1) searchCurve.show(history, 'step of the search');
}

function chooseAnswer(idx) {
  state.answerIdx = idx;
  document.body.dataset.answer = idx;
  [...byId('answers').children].forEach((button, other) => button.setAttribute('aria-pressed', other === idx));
  const way = chosenWay();
  byId('slider').max = way.length - 1;
  showTables();
  showCurves();
  moveTo(way.length - 1);
}

function legend(holder, objects) {
  holder.replaceChildren(...objects.map((object, idx) => {
    const words = document.createElement('span');
    const patch = document.createElement('i');
    patch.style.background = `rgb(${content.colours[idx].map((level) => Math.round(255 * level)).join(' ')})`;
    words.append(patch, `${object.role}: ${object.id}`);
    return words;
  }));
}

function chooseCase(idx) {
  state.caseIdx = idx;
  document.body.dataset.case = idx;
  const chosen = chosenCase();
  byId('cases').value = idx;
  const mark = document.createElement('b');
  mark.className = chosen.success ? 'good' : 'bad';
  mark.textContent = chosen.success ? 'imitated' : 'not imitated';
  byId('verdict').replaceChildren(mark, chosen.message);
  legend(byId('reference-legend'), chosen.reference.objects);
  legend(byId('test-legend'), chosen.test.objects);
  byId('answers').replaceChildren(...chosen.answers.map((answer, other) => {
    const button = document.createElement('button');
    button.type = 'button';
    button.textContent = `answer ${other + 1}: ${answer.distance === null ? '–' : answer.distance.toFixed(3)}${answer.feasible ? '' : ', not feasible'}`;
    button.addEventListener('click', () => chooseAnswer(other));
    return button;
  }));
  const { reference, test } = chosen;
  if (views.reference) views.reference.frame(cornersOf(reference.objects, reference.objects.map((object) => object.pose)));
  if (views.test) {
    const ends = chosen.answers.flatMap((answer) => answer.way.flatMap((step) => cornersOf(test.objects, step.poses)));
    views.test.frame(ends);
  }
  chooseAnswer(0);
}

function play() {
  stop();
  const way = chosenWay();
  const end = way.length - 1;
  if (state.at >= end) moveTo(0);
  const from = state.at;
  const seconds = PLAY_SECONDS * (end - from) / end;
  const start = performance.now();
  byId('play').textContent = '❚❚';
  byId('play').setAttribute('aria-label', 'Pause');
  const tick = (now) => {
    moveTo(from + (end - from) * Math.min(1, Math.max(0, now - start) / (1000 * seconds)));
    if (state.at < end) state.playing = requestAnimationFrame(tick);
    else stop();
  };
  state.playing = requestAnimationFrame(tick);
}

function stop() {
  cancelAnimationFrame(state.playing);
  state.playing = 0;
  byId('play').textContent = '▶';
  byId('play').setAttribute('aria-label', 'Play');
}

byId('slider').addEventListener('input', () => { stop(); moveTo(Number(byId('slider').value)); });
byId('play').addEventListener('click', () => (state.playing ? stop() : play()));
byId('ghosts').addEventListener('change', drawScenes);
byId('theme').addEventListener('click', () => {
  const isDark = getComputedStyle(document.documentElement).colorScheme === 'dark'
    || (!document.documentElement.dataset.theme && matchMedia('(prefers-color-scheme: dark)').matches);
  document.documentElement.dataset.theme = isDark ? 'light' : 'dark';
  drawScenes();
});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', drawScenes);
byId('cases').append(...content.cases.map((shown, idx) => new Option(shown.title, idx)));
byId('cases').hidden = content.cases.length < 2;
byId('cases').addEventListener('change', () => { stop(); chooseCase(Number(byId('cases').value)); });

// #case=1&answer=2&at=0.5: a link to what is shown; also for checks without a mouse.
const wanted = new URLSearchParams(location.hash.slice(1));
const within = (name, count) => Math.min(count - 1, Math.max(0, Number(wanted.get(name)) || 0));
if (wanted.get('theme')) document.documentElement.dataset.theme = wanted.get('theme') === 'dark' ? 'dark' : 'light';
chooseCase(within('case', content.cases.length));
chooseAnswer(within('answer', chosenCase().answers.length));
if (wanted.has('at')) moveTo(Number(wanted.get('at')) * (chosenWay().length - 1));
document.body.dataset.ready = 'yes';
