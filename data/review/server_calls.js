// What the page asks of the server. Addresses are relative: the token is the first part of the path.
'use strict';

class Refused extends Error {
  constructor(status, text) {
    super(text);
    this.status = status;
  }
}

async function answerOf(response) {
  const text = await response.text();
  let answer = {};
  try {
    answer = JSON.parse(text);
  } catch {
    answer = {error: text.trim()};
  }
  if (!response.ok) throw new Refused(response.status, answer.error || response.statusText);
  return answer;
}

async function reached(request) {
  try {
    return await request;
  } catch {
    throw new Refused(0, 'The program does not answer any more: start orient review again. ' +
        'What it has confirmed is written.');
  }
}

const server = {
  async get(path) {
    return answerOf(await reached(fetch(path, {cache: 'no-store'})));
  },
  async post(path, body) {
    return answerOf(await reached(fetch(path, {
      method: 'POST',
      headers: {'Content-Type': 'application/json'},
      body: JSON.stringify(body),
    })));
  },
  list() { return this.get('api/list'); },
  photo(name) { return this.get('api/photo/' + encodeURIComponent(name)); },
  map() { return this.get('api/map'); },
  seen(photo, mark, pixel) {
    return this.get('api/seen?' + new URLSearchParams({photo, mark, col: pixel[0], row: pixel[1]}));
  },
  height(x, y) { return this.get('api/height?x=' + x + '&y=' + y); },
  progress() { return this.get('api/progress'); },
  say(word) { return this.post('api/say', word); },
  undo(version) { return this.post('api/undo', {version}); },
  again() { return this.post('api/again', {}); },
};

// Names and reasons come from files: text, never markup.
function element(tag, text, className) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  return made;
}
