// What a person does on the page: photos in turn, clicks, decisions, by mouse or keys.
'use strict';

const review = {list: null, photo: null, map: null, mode: null, showsMap: false,
  pixel: null, runs: 0};
const photoView = new PhotoView('photo_view', (pixel) => measureAt(pixel));
const mapView = new MapView('map_view', (ground) => takeGround(ground), (name) => {
  if (review.pixel || review.mode === 'place') return false;
  guarded(() => choose(name));
  return true;
}, (name, ground) => guarded(() => sayPosition(name, ground)), () => review.pixel || review.mode);

// One action after another; what goes wrong is told, and the page shows what is true now.
let latest = Promise.resolve();
function guarded(action) {
  latest = latest.then(action).catch(async (error) => {
    tell(error.message);
    if (error.status === 409) await refresh().catch(() => {});
  });
  return latest;
}

const listed = (name) => review.list.photos.find((photo) => photo.name === name);
const shownPhotos = () => review.list.photos.filter(matchesFilter);
const drawList = () =>
  showList(review.list, review.photo && review.photo.name, (name) => guarded(() => choose(name)));

async function refresh() {
  review.list = await server.list();
  review.map = await server.map();
  if (review.photo) await show(review.photo.name);
  drawList();
}

async function show(name) {
  const changed = !review.photo || review.photo.name !== name;
  review.photo = await server.photo(name);
  if (changed) leaveMode();
  if (changed) at('mark').value = at('value').value = at('why').value = '';
  if (changed) at('exact').checked = false;
  showPanel(review.photo, listed(name), (word, about) => guarded(() => say(word, 'withdrawal of ' + about)));
  showValues(review.photo);
  showLegend(photoView.show(review.photo));
  mapView.show(review.map, name);
  mapView.showPatches(review.photo);
}

async function choose(name) {
  tell('');
  await show(name);
  drawList();
  const row = document.querySelector('#photos [aria-current="true"]');
  if (row) row.scrollIntoView({block: 'nearest'});
}

async function step(by) {
  const photos = shownPhotos();
  if (!photos.length) return;
  const now = photos.findIndex((photo) => review.photo && photo.name === review.photo.name);
  const next = now < 0 ? 0 : (now + by + photos.length) % photos.length;
  await choose(photos[next].name);
}

async function say(word, about, photo = review.photo.name) {
  const whole = about + ' of photo ' + photo;
  await server.say({...word, version: review.list.version, about: whole});
  await refresh();
  tell('Saved: ' + whole, true);
}

async function decide(photo, decision, value, reason) {
  await say({decisions: [{photo, decision, value, reason}]}, (decision + ' ' + value).trim(), photo);
  at('why').value = at('value').value = '';
}

// Of the photo that is shown at this moment, whichever is when its turn comes.
function decideShown(decision, value = '') {
  if (!review.photo) return;
  const {name} = review.photo, reason = at('why').value.trim();
  guarded(() => decide(name, decision, value, reason));
}

async function undo() {
  const about = review.list.undo;
  await server.undo(review.list.version);
  await refresh();
  tell('Taken back: ' + about, true);
}

// The keys are the view's, whatever was clicked to begin.
function enterMode(mode, hint, inMap = false) {
  review.mode = mode;
  at('hint').textContent = hint;
  document.body.classList.add('measuring');
  document.activeElement.blur();
  mapView.showHandle();
  showTab(inMap);
}

function leaveMode() {
  review.mode = review.pixel = null;
  at('hint').textContent = '';
  at('crosshair').hidden = true;
  at('point_form').hidden = true;
  document.body.classList.remove('measuring');
  mapView.showHandle();
}

// The next mark that nobody has clicked: those not found first.
function nextMark() {
  const marks = review.photo.interior ? review.photo.interior.marks : [];
  const said = new Set(review.photo.said.marks.map((one) => one.mark));
  const order = [...marks.filter((mark) => mark.state !== 'used'),
    ...marks.filter((mark) => mark.state === 'used')].map((mark) => mark.id);
  const open = order.filter((id) => !said.has(id));
  const now = open.indexOf(at('mark').value);
  return review.mode === 'mark' && open.length ? open[(now + 1) % open.length] :
    at('mark').value || open[0] || '';
}

function measureMark() {
  if (!review.photo || !review.photo.scan) return;
  at('mark').value = nextMark();
  if (!at('mark').value) {
    tell('Name the mark as the camera file does, then measure it.');
    at('mark').focus();
    return;
  }
  enterMode('mark', 'Click mark ' + at('mark').value + ', or move it under the cross and press Enter');
}

function measurePoint() {
  if (!review.photo || !review.photo.scan) return;
  leaveMode();
  enterMode('point', 'Click the ground point, or move it under the cross and press Enter');
}

// Where the photo was taken, roughly: an approximation.
function placePhoto() {
  if (!review.photo) return;
  leaveMode();
  enterMode('place', 'Click where ' + review.photo.name +
      ' was taken, or move it under the cross and press Enter', true);
}

async function sayPosition(photo, ground) {
  try {
    if (!at('place_sigma').value.trim()) at('place_sigma').value = mapView.roughly(review.map);
    const value = ground[0].toFixed(1) + ' ' + ground[1].toFixed(1) + ' ' + numberIn('place_sigma');
    await decide(photo, 'position', value, at('why').value.trim());
  } catch (error) {
    mapView.show(review.map, review.photo.name);  // the handle goes back
    throw error;
  }
}

function measureAt(pixel) {
  const {scan} = review.photo || {};
  if (!review.mode || !scan) return;
  if (pixel[0] < 0 || pixel[1] < 0 || pixel[0] > scan.width || pixel[1] > scan.height) {
    tell('That is outside of the scan.');
    return;
  }
  const {name} = review.photo, mark = at('mark').value.trim();
  if (review.mode === 'mark') guarded(() => sayMark(name, mark, pixel));
  if (review.mode === 'point') openPointForm(pixel);
}

async function sayMark(photo, mark, pixel) {
  await say({marks: [{photo, mark, pixel, sigma: 1, exact: at('exact').checked}]}, 'mark ' + mark,
      photo);
  leaveMode();
  at('mark').value = '';
  await showSeen(photo, mark, pixel);
}

// The mark measured at once, as far as one mark alone can be.
async function showSeen(photo, mark, pixel) {
  const seen = await server.seen(photo, mark, pixel);
  if (!seen.pixel || review.photo.name !== photo || review.mode) return;
  const off = Math.hypot(seen.pixel[0] - pixel[0], seen.pixel[1] - pixel[1]).toFixed(1);
  const likeness = 'correlation ' + seen.correlation.toFixed(2);
  const isThere = seen.correlation >= 0.5;
  at('hint').textContent = isThere ?
    'Mark ' + mark + ' measured ' + off + ' px beside the click, ' + likeness :
    'Nothing like mark ' + mark + ' is seen there: ' + likeness;
  if (isThere) photoView.seen(seen.pixel, 'measured: mark ' + mark);
}

function openPointForm(pixel) {
  leaveMode();
  review.pixel = pixel;
  mapView.showHandle();
  at('point_form').hidden = false;
  at('point_pixel').textContent = 'In the photo' + pixelText(pixel);
  const names = review.map.points.map((point) => point.point);
  const taken = new Set([...names, ...review.map.measured_points]);
  let number = 1;
  while (taken.has('p' + number)) ++number;
  at('point').value = 'p' + number;
  at('x').value = at('y').value = at('z').value = '';
  at('points').replaceChildren(...names.map((name) => {
    const option = element('option');
    option.value = name;
    return option;
  }));
  at('hint').textContent = 'Now the same point in the map, or its coordinates';
  at('x').focus();
}

// A point that is known already keeps its coordinates.
function takeKnownPoint() {
  const known = review.map.points.find((point) => point.point === at('point').value);
  if (!known) return;
  ['x', 'y', 'z'].forEach((id, i) => { at(id).value = known.ground[i]; });
  [at('sigma_xy').value, , at('sigma_z').value] = known.sigma;
  at('role').value = known.role;
}

async function fillGround(ground) {
  at('x').value = ground[0].toFixed(2);
  at('y').value = ground[1].toFixed(2);
  const {z} = await server.height(ground[0], ground[1]);
  at('z').value = z === null ? '' : z.toFixed(2);
  at(z === null ? 'z' : 'point').focus();  // Enter saves
  tell(z === null ? 'There is no height here: type z.' : '');
}

function takeGround(ground) {
  if (!ground && (review.pixel || review.mode === 'place')) {
    tell('The map shows nothing here yet, so no place can be clicked: start with --ortho RASTER, ' +
        'or type the coordinates.');
    return;
  }
  if (review.pixel) guarded(() => fillGround(ground));
  if (review.mode !== 'place') return;
  const {name} = review.photo;
  leaveMode();  // one click says it once
  guarded(() => sayPosition(name, ground));
}

const numberIn = (id) => {
  const number = Number(at(id).value.trim().replace(',', '.'));
  if (at(id).value.trim() === '' || !Number.isFinite(number)) {
    at(id).focus();
    throw new Error(id.replace('_', ' ') + ' is not a number.');
  }
  return number;
};

async function savePoint() {
  const point = at('point').value.trim();
  const ground = ['x', 'y', 'z'].map(numberIn);
  const xy = numberIn('sigma_xy'), sigma = [xy, xy, numberIn('sigma_z')];
  const known = review.map.points.find((one) => one.point === point);
  const differs = (a, b) => a.some((number, i) => number !== b[i]);
  // Of x and y with sigmas of their own the form has one.
  const kept = known && known.sigma[0] === xy ? [xy, known.sigma[1], sigma[2]] : sigma;
  const changed = !known || differs(known.ground, ground) || differs(known.sigma, kept) ||
      known.role !== at('role').value;
  await say({
    image_points: [{photo: review.photo.name, point, pixel: review.pixel, sigma: 1}],
    points: changed ? [{point, ground, sigma: kept, role: at('role').value}] : [],
  }, 'point ' + point);
  leaveMode();
}

function showTab(map) {
  review.showsMap = map;
  at('photo_view').classList.toggle('away', map);
  at('map_view').classList.toggle('away', !map);
  at('show_photo').setAttribute('aria-selected', String(!map));
  at('show_map').setAttribute('aria-selected', String(map));
  const places = review.mode === 'place';
  const measures = map ? Boolean(review.pixel) || places : Boolean(review.mode) && !places;
  at('crosshair').hidden = !measures;
  at('no_scan').classList.toggle('away', map);
}

async function again() {
  await server.again();
  tell('');
  watch();
}

// Until the run has ended; then the page shows what came of it.
async function watch() {
  let now;
  try {
    now = await server.progress();
  } catch (error) {
    tell(error.message);
    return;
  }
  at('again').hidden = !now.offered;
  at('again').disabled = now.running;
  at('running').hidden = !now.running;
  at('bar').value = now.total ? now.done / now.total : 0;
  at('task').textContent = now.task ? now.task + ' ' + now.done + ' of ' + now.total : 'begins';
  const before = review.runs;
  review.runs = now.running ? now.runs : 0;
  if (now.running) {
    setTimeout(watch, 500);
  } else if (before) {
    ended(now.error);
  }
}

function ended(error) {
  return guarded(async () => {
    await refresh();
    if (error) tell('It could not be done: ' + error);
    else tell('Oriented again.' + stillPending(), true);
  });
}

// Photos that the run did not know, or whose scans were not named to it.
function stillPending() {
  const names = review.list.photos.filter((photo) => photo.pending).map((photo) => photo.name);
  return names.length ? ' Still pending: ' + names.join(', ') : '';
}

const currentMap = () => (review.showsMap ? mapView : photoView).map;

const PANS = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};

function measureAtCentre() {
  if (review.showsMap) takeGround(mapView.centre());
  else measureAt(photoView.centre());
}

const KEYS = {
  n: () => guarded(() => step(1)),
  p: () => guarded(() => step(-1)),
  a: () => at('accept').click(),
  r: () => at('reject').click(),
  m: measureMark,
  g: measurePoint,
  o: placePhoto,
  u: () => at('undo').click(),
  d: () => at('again').hidden || at('again').click(),
  t: () => showTab(!review.showsMap),
  '?': () => at('help_dialog').showModal(),
  '+': () => currentMap().zoomIn(),
  '-': () => currentMap().zoomOut(),
  Enter: measureAtCentre,
  Escape: leaveMode,
};

function onKey(event) {
  if (event.ctrlKey || event.altKey || event.metaKey || at('help_dialog').open) return;
  const field = event.target.matches('input:not([type=checkbox]), select');
  if (field && event.key === 'Escape') event.target.blur();
  if (field || (event.key === 'Enter' && event.target.matches('button'))) return;
  if (PANS[event.key]) {
    currentMap().panBy(PANS[event.key].map((way) => way * (event.shiftKey ? 1 : 60)),
        {animate: false});
    event.preventDefault();
  } else if (KEYS[event.key]) {
    KEYS[event.key]();
    event.preventDefault();
  }
}

function begin() {
  const onClick = (id, action) => at(id).addEventListener('click', action);
  onClick('accept', () => decideShown('accept'));
  onClick('reject', () => decideShown('reject'));
  onClick('decide', () => decideShown(at('kind').value, at('value').value.trim()));
  onClick('measure', measureMark);
  onClick('ground', measurePoint);
  onClick('place', placePhoto);
  onClick('undo', () => guarded(undo));
  onClick('again', () => guarded(again));
  onClick('help', KEYS['?']);
  onClick('close_help', () => at('help_dialog').close());
  onClick('drop_point', leaveMode);
  onClick('show_photo', () => showTab(false));
  onClick('show_map', () => showTab(true));
  at('point').addEventListener('change', takeKnownPoint);
  at('kind').addEventListener('change', () => showValues(review.photo));
  at('state').addEventListener('change', drawList);
  at('reason').addEventListener('change', drawList);
  at('point_form').addEventListener('submit', (event) => {
    event.preventDefault();
    guarded(savePoint);
  });
  document.addEventListener('keydown', onKey);
  // The cross stays the middle of the view, also when a message takes room from it.
  new ResizeObserver(() => [photoView, mapView].forEach(
      (view) => view.map.invalidateSize({animate: false}))).observe(at('stage'));
  showTab(false);
  guarded(async () => {
    await refresh();
    await step(1);
    await watch();
  });
}

begin();
