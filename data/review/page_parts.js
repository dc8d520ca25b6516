// The list of photos and the panel of the photo that is shown.
'use strict';

const at = (id) => document.getElementById(id);

function isDone(photo) {
  return photo.decisions.length > 0 || photo.said > 0;
}

function matchesFilter(photo) {
  const state = at('state').value, reason = at('reason').value;
  if (state === 'pending' && !photo.pending) return false;
  if (state && state !== 'pending' && photo.status !== state) return false;
  return !reason || photo.codes.includes(reason);
}

function showReasons(photos) {
  const codes = [...new Set(photos.flatMap((photo) => photo.codes))].sort();
  const chosen = at('reason').value;
  at('reason').replaceChildren(element('option', 'all'), ...codes.map((code) => {
    const option = element('option', code);
    option.value = code;
    return option;
  }));
  at('reason').firstChild.value = '';
  at('reason').value = codes.includes(chosen) ? chosen : '';
}

function showList(list, current, choose) {
  showReasons(list.photos);
  const rows = list.photos.filter(matchesFilter).map((photo) => {
    const button = element('button');
    button.setAttribute('aria-current', String(photo.name === current));
    button.append(element('span', photo.status, 'state ' + photo.status), ' ',
        element('span', photo.name));
    if (photo.concern) button.append(element('small', photo.concern));
    if (photo.pending) button.append(element('small', 'pending', 'pending'));
    for (const one of photo.decisions) {
      button.append(element('small', 'decided: ' + (one.decision + ' ' + one.value).trim()));
    }
    button.addEventListener('click', () => choose(photo.name));
    const row = element('li');
    row.append(button);
    return row;
  });
  at('photos').replaceChildren(...rows);
  const toSee = list.photos.filter((photo) => photo.status !== 'ok' || isDone(photo));
  at('reviewed').textContent = (list.photos.length === 1 ? '1 photo, ' :
    list.photos.length + ' photos, ') + (toSee.length ?
    toSee.filter(isDone).length + ' of ' + toSee.length + ' reviewed' : 'all ok');
  at('title').textContent = list.title;
  at('undo').disabled = !list.undo;
  at('undo').title = list.undo ? 'take back: ' + list.undo : 'there is nothing to take back';
}

function saidRow(text, said, takeBack) {
  const row = element('li');
  const who = [said.by, said.when].filter(Boolean).join(', ');
  row.append(element('span', who ? text + ' (' + who + ')' : text));
  const button = element('button', 'Withdraw');
  button.addEventListener('click', takeBack);
  row.append(button);
  return row;
}

const pixelText = (pixel) =>
  pixel ? ' at ' + pixel.map((number) => number.toFixed(1)).join(', ') : '';

// `withdraw` gets the word that takes it back.
function showSaid(photo, withdraw) {
  const {marks, points, decisions} = photo.said;
  const rows = marks.map((one) => saidRow('mark ' + one.mark + pixelText(one.pixel), one.said,
      () => withdraw({no_marks: [[photo.name, one.mark]]}, 'mark ' + one.mark)));
  rows.push(...points.map((one) => saidRow('point ' + one.point + pixelText(one.pixel) +
      (one.ground ? '' : ', without coordinates'), one.said,
  () => withdraw({no_image_points: [[photo.name, one.point]]}, 'point ' + one.point))));
  rows.push(...points.filter((one) => one.ground).map((one) => saidRow(
      'coordinates of ' + one.point + ': ' + one.ground.map((c) => c.toFixed(2)).join(', '),
      one.ground_said,
      () => withdraw({no_points: [one.point]}, 'coordinates of point ' + one.point))));
  rows.push(...decisions.map((one) => saidRow(
      [one.decision, one.value, one.reason].filter(Boolean).join(' '), one.said,
      () => withdraw({no_decisions: [[photo.name, one.decision]]}, one.decision))));
  at('said').replaceChildren(...(rows.length ? rows : [element('li', 'nothing')]));
}

function showMarks(photo) {
  const marks = photo.interior ? photo.interior.marks : [];
  at('mark_table').tBodies[0].replaceChildren(...marks.map((mark) => {
    const row = element('tr');
    row.append(element('td', mark.id), element('td', mark.state),
        element('td', mark.residual_um ? mark.residual_um.map((r) => r.toFixed(1)).join(', ') : '–'));
    return row;
  }));
  at('marks').replaceChildren(...marks.map((mark) => {
    const option = element('option');
    option.value = mark.id;
    return option;
  }));
}

function showPanel(photo, listed, withdraw) {
  at('name').textContent = photo.name;
  at('status').textContent = photo.status;
  at('status').className = 'state ' + photo.status;
  at('pending').hidden = !listed.pending;
  at('reasons').replaceChildren(...photo.reasons.map((reason) => element('li', reason)));
  at('accept').disabled = photo.status === 'failed';
  at('no_scan').hidden = Boolean(photo.scan);
  at('no_scan').textContent = photo.scan ? '' : 'No picture: ' + photo.why_no_scan;
  showMarks(photo);
  showSaid(photo, withdraw);
}

const VALUES = {
  orientation: ['r0', 'r90', 'r180', 'r270', 'm0', 'm90', 'm180', 'm270'],
  polarity: ['positive', 'negative'],
  pixel_size: [],
  camera: [],
  position: [],
};

function showValues(photo) {
  const kind = at('kind').value;
  const values = kind === 'camera' && photo && photo.interior ? photo.interior.cameras :
    VALUES[kind];
  at('values').replaceChildren(...values.map((value) => {
    const option = element('option');
    option.value = value;
    return option;
  }));
}

function showLegend(times) {
  at('legend').textContent = 'Green: used. Orange: rejected. Grey: not found. Pink: said. ' +
      'Residuals (measured - computed) of marks times ' + times.marks + ', patches ' +
      times.patches + ', ties ' + times.ties + '.';
}

function tell(text, good) {
  at('message').textContent = text;
  at('message').className = good ? 'good' : '';
  at('message').hidden = !text;
}
