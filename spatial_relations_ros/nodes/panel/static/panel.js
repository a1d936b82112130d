// The page: what the panel tells is shown, what is chosen is asked. Everything is written as text, never as markup.

const byId = (id) => document.getElementById(id);
const SELECTS = ['reference-base', 'reference-relative', 'test-base', 'test-relative'];
const surfaces = new Surfaces();
const views = Object.fromEntries(['seen', 'reference', 'test'].map((id) => [id, new SceneView(byId(id), surfaces)]));
const curve = new Curve(byId('curve'));
const state = { objects: [], table: 0, relations: [], eye: null, isPlaced: false, result: null, resultIdx: 0, answerIdx: 0, at: 1, progress: null, running: false };
const replies = new Map();
let socket = null;
let asked = 0;
let pause = 500;

function connect() {
  socket = new WebSocket(`${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/socket`);
  socket.addEventListener('open', () => { pause = 500; showConnection('connected'); });
  socket.addEventListener('message', (event) => take(JSON.parse(event.data)));
  socket.addEventListener('close', () => {
    showConnection('lost');
    for (const reply of replies.values()) reply({ ok: false, message: 'the panel did not answer' });
    replies.clear();
    setTimeout(connect, pause);
    pause = Math.min(5000, 2 * pause);
  });
}

function showConnection(is) {
  byId('connection').dataset.is = is;
  byId('connection').textContent = is === 'lost' ? 'the panel does not answer; trying again' : is;
  document.body.dataset.connection = is;
  enable();
}

function take(message) {
  const takers = { objects: takeObjects, relations: takeRelations, job: takeJob, progress: takeProgress, result: takeResult, reply: takeReply };
  if (takers[message.type]) takers[message.type](message);
}

function ask(content) {
  if (!socket || socket.readyState !== WebSocket.OPEN) return Promise.resolve({ ok: false, message: 'there is no connection to the panel' });
  asked += 1;
  socket.send(JSON.stringify({ id: asked, ...content }));
  return new Promise((resolve) => replies.set(asked, resolve));
}

function takeReply(reply) {
  const resolve = replies.get(reply.id);
  replies.delete(reply.id);
  if (resolve) resolve(reply);
}

function say(id, text, isBad) {
  byId(id).textContent = text;
  byId(id).hidden = !text;
  byId(id).className = `said ${isBad ? 'bad' : ''}`;
}

// What is seen.

function takeObjects(message) {
  state.objects = message.objects;
  if (message.table !== null) state.table = message.table;
  state.eye = message.eye;
  byId('problem').textContent = message.problem;
  byId('problem').hidden = !message.problem;
  const rows = message.objects.map((object) => {
    const row = document.createElement('tr');
    row.dataset.id = object.id;
    row.insertCell().textContent = object.id;
    const mark = document.createElement('span');
    mark.className = 'state';
    mark.dataset.is = object.state;
    mark.textContent = object.state || 'not used';
    row.insertCell().append(mark);
    row.insertCell().textContent = object.reason;
    return row;
  });
  byId('objects').tBodies[0].replaceChildren(...rows);
  fillSelects();
  drawSeen();
}

function fillSelects() {
  const ids = state.objects.map((object) => object.id);
  const seen = new Set(state.objects.filter((object) => object.is_seen).map((object) => object.id));
  SELECTS.forEach((id, idx) => {
    const select = byId(id);
    const wanted = select.value || [...seen][idx] || '';
    const names = wanted && !ids.includes(wanted) ? [...ids, wanted] : ids;
    const words = names.map((name) => (seen.has(name) ? name : `${name} (not seen)`));
    if ([...select.options].map((option) => option.text).join('\n') !== words.join('\n')) {
      select.replaceChildren(...names.map((name, place) => new Option(words[place], name)));
    }
    select.value = wanted;
  });
  enable();
}

function roleOf(id) {
  const named = byId('reference-name').value;
  const bases = [byId('test-base').value, ...(named ? [] : [byId('reference-base').value])];
  const relatives = [byId('test-relative').value, ...(named ? [] : [byId('reference-relative').value])];
  if (bases.includes(id)) return 'base';
  return relatives.includes(id) ? 'relative' : 'other';
}

function drawSeen() {
  const objects = state.objects.filter((object) => object.model)
    .map((object) => ({ ...object, role: roleOf(object.id), alpha: object.is_seen ? 1 : GHOST_ALPHA }));
  views.seen.show(objects, state.table, objects, objects.map((object) => object.id).join('\n'));
  if (state.eye && views.seen.framed && !state.isPlaced) {
    state.isPlaced = true;
    views.seen.viewer.standAt(state.eye);
  }
}

// Names below the objects, where they hide least.
function drawLabels() {
  const { viewer } = views.seen;
  const labels = state.objects.filter((object) => object.model && surfaces.known.get(object.model)).map((object) => {
    const corners = cornersOf(surfaces.known.get(object.model), object.pose).map((corner) => viewer.place(corner));
    const x = corners.reduce((sum, corner) => sum + corner[0], 0) / 8;
    const y = Math.max(...corners.map((corner) => corner[1]));
    const label = document.createElement('span');
    label.textContent = object.id;
    label.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -25%)`;
    return label;
  });
  byId('labels').replaceChildren(...labels);
}

// Remembered relations.

function takeRelations(message) {
  const isNew = JSON.stringify(message.relations) !== JSON.stringify(state.relations) || !byId('reference-name').options.length;
  if (message.problem) say('relations-said', message.problem, true);
  else if (byId('relations-said').className.includes('bad')) say('relations-said', '');
  if (!isNew) return;
  state.relations = message.relations;
  const select = byId('reference-name');
  const wanted = select.value;
  select.replaceChildren(new Option('two objects that are seen', ''), ...message.relations.map((relation) => new Option(relation.name, relation.name)));
  select.value = message.relations.some((relation) => relation.name === wanted) ? wanted : '';
  byId('relations').replaceChildren(...message.relations.map(relationRow));
  enable();
}

function relationRow(relation) {
  const row = document.createElement('li');
  const words = document.createElement('span');
  words.className = 'words';
  words.textContent = relation.name;
  const pair = document.createElement('small');
  pair.textContent = `${relation.relative} to ${relation.base}`;
  words.append(pair);
  row.append(words, button('Use', `Imitate from ${relation.name}`, () => {
    byId('reference-name').value = relation.name;
    enable();
    drawSeen();
  }), button('Forget', `Forget ${relation.name}`, async () => {
    const reply = await ask({ type: 'forget', name: relation.name });
    say('relations-said', reply.message, !reply.ok);
  }));
  return row;
}

function button(text, label, onClick) {
  const element = document.createElement('button');
  element.type = 'button';
  element.textContent = text;
  element.setAttribute('aria-label', label);
  element.addEventListener('click', onClick);
  return element;
}

// Imitations.

const pairOf = (name) => [byId(`${name}-base`).value, byId(`${name}-relative`).value];

function enable() {
  const isConnected = document.body.dataset.connection === 'connected';
  const named = byId('reference-name').value;
  byId('reference-pair').hidden = Boolean(named);
  const whole = (pair) => pair.every(Boolean) && pair[0] !== pair[1];
  byId('imitate').disabled = !isConnected || state.running || !whole(pairOf('test')) || !(named || whole(pairOf('reference')));
  byId('remember').disabled = !isConnected || Boolean(named) || !whole(pairOf('reference'));
  byId('cancel').hidden = !state.running;
}

function takeJob(message) {
  state.running = message.running;
  document.body.dataset.running = message.running;
  byId('progress').textContent = message.running ? `imitating: ${message.message}` : '';
  say('said', message.running ? '' : message.message, true);
  enable();
}

function takeProgress(message) {
  if (!state.running) return;
  const distance = message.distance === null ? '–' : message.distance.toFixed(3);
  byId('progress').textContent = `step ${message.step}, distance ${distance}${message.feasible ? '' : ', not feasible yet'}`;
}

function takeResult(message) {
  state.result = message;
  state.resultIdx += 1;
  byId('result').hidden = false;
  const mark = document.createElement('b');
  mark.className = message.success ? 'good' : 'bad';
  mark.textContent = message.success ? 'imitated' : 'not imitated';
  byId('verdict').replaceChildren(mark, `${message.message}${message.duration === null ? '' : ` · ${message.duration.toFixed(1)} s`}`);
  legend(byId('reference-legend'), message.reference.objects);
  legend(byId('test-legend'), message.test.objects);
  byId('answers').replaceChildren(...message.answers.map((answer, idx) => {
    const words = `answer ${idx + 1}: ${answer.distance === null ? '–' : answer.distance.toFixed(3)}${answer.feasible ? '' : ', not feasible'}`;
    return button(words, words, () => chooseAnswer(idx));
  }));
  const history = message.history.map((value, idx) => [idx, value]).filter((point) => point[1] !== null);
  curve.show(history, 'step of the search');
  chooseAnswer(0);
  document.body.dataset.result = state.resultIdx;
}

function legend(holder, objects) {
  holder.replaceChildren(...objects.map((object) => {
    const words = document.createElement('span');
    const patch = document.createElement('i');
    patch.className = object.role;
    words.append(patch, `${object.role}: ${object.id}`);
    return words;
  }));
}

function chooseAnswer(idx) {
  state.answerIdx = idx;
  document.body.dataset.answer = idx;
  [...byId('answers').children].forEach((element, other) => element.setAttribute('aria-pressed', other === idx));
  showChecks();
  moveTo(1);
}

function showChecks() {
  const answer = state.result.answers[state.answerIdx];
  byId('checks').replaceChildren();
  if (!answer) return;
  const row = (name, value, passed) => {
    const cells = byId('checks').insertRow();
    cells.insertCell().textContent = name;
    cells.insertCell().textContent = value;
    const mark = cells.insertCell();
    mark.className = `mark ${passed ? 'good' : 'bad'}`;
    if (passed === undefined) return;
    mark.textContent = passed ? '✓' : '✗';
    mark.setAttribute('aria-label', passed ? 'passed' : 'failed');
  };
  const before = state.result.initial_distance;
  const words = (value) => (value === null ? '–' : value.toFixed(3));
  row('distance', `${words(answer.distance)}, before ${words(before)}`, answer.distance !== null && before !== null && answer.distance < before);
  if (answer.confidence !== null) row('confidence', `${Math.round(100 * answer.confidence)} %`);
  row('feasible', answer.feasible ? 'yes' : 'no', answer.feasible);
  for (const violation of answer.violations) row('violated', violation, false);
  for (const target of answer.targets) {
    if (!target.moves) {
      row(target.id, 'stays');
      continue;
    }
    row(target.id, 'moves');
    if (target.penetration !== null) row('deepest overlap', `${(1000 * target.penetration).toFixed(1)} mm`, target.penetration < 0.005);
    row('carried from below', target.supported ? 'yes' : 'no', target.supported);
    row('in reach', target.reachable ? 'yes' : 'no', target.reachable);
  }
}

function moveTo(at) {
  state.at = at;
  byId('slider').value = at;
  byId('moment').textContent = at === 0 ? 'before' : at === 1 ? 'after' : 'on the way';
  byId('slider').setAttribute('aria-valuetext', byId('moment').textContent);
  document.body.dataset.at = at.toFixed(2);
  drawResult();
}

function drawResult() {
  if (!state.result) return;
  const { reference, test, answers } = state.result;
  const ends = (answers[state.answerIdx] || { poses: test.objects.map((object) => object.pose) }).poses;
  const solid = (object) => ({ ...object, alpha: 1 });
  views.reference.show(reference.objects.map(solid), reference.table, reference.objects, state.resultIdx);
  const moved = test.objects.map((object, idx) => ({ ...object, pose: poseBetween(object.pose, ends[idx], state.at), alpha: 1 }));
  const ghosts = test.objects.filter((object, idx) => object.pose.some((value, part) => Math.abs(value - moved[idx].pose[part]) > 1e-4))
    .map((object) => ({ ...object, alpha: GHOST_ALPHA }));
  const frame = [...test.objects, ...answers.flatMap((answer) => test.objects.map((object, idx) => ({ ...object, pose: answer.poses[idx] })))];
  views.test.show([...moved, ...ghosts], test.table, frame, state.resultIdx);
}

byId('ask').addEventListener('submit', async (event) => {
  event.preventDefault();
  const named = byId('reference-name').value;
  say('said', '');
  const reply = await ask({
    type: 'imitate', ...(named ? { reference_name: named } : { reference: pairOf('reference') }), test: pairOf('test'),
    movable: byId('movable').value, answers: Number(byId('answers-wanted').value), keep_heading: byId('keep-heading').checked,
    time_budget: Number(byId('time-budget').value),
  });
  if (!reply.ok) say('said', reply.message, true);
});
byId('cancel').addEventListener('click', () => ask({ type: 'cancel' }));
byId('keep').addEventListener('submit', async (event) => {
  event.preventDefault();
  const reply = await ask({ type: 'remember', name: byId('name').value, objects: pairOf('reference'), replace: byId('replace').checked });
  say('relations-said', reply.message, !reply.ok);
  if (reply.ok) byId('name').value = '';
});
for (const id of [...SELECTS, 'reference-name']) byId(id).addEventListener('change', () => { enable(); drawSeen(); });
byId('slider').addEventListener('input', () => moveTo(Number(byId('slider').value)));

function redraw() { drawSeen(); drawResult(); }

byId('theme').addEventListener('click', () => {
  const isDark = document.documentElement.dataset.theme === 'dark'
    || (!document.documentElement.dataset.theme && matchMedia('(prefers-color-scheme: dark)').matches);
  document.documentElement.dataset.theme = isDark ? 'light' : 'dark';
  redraw();
});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
surfaces.onLoad = redraw;
if (views.seen.viewer) {
  views.seen.viewer.onDraw = drawLabels;
  // What is framed is a ball around all; a table with objects is flat.
  views.seen.viewer.camera.zoom = 0.72;
}
connect();
