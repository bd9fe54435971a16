'use strict';
// One <img> per camera. Browsers open at most six connections to a host, so with more cameras than that the rest
// show snapshots, one after the other. A hidden page reads nothing and so costs the rig nothing.
const liveStreams = 4;
const lookAgainMs = 3000;
const snapshotMs = 1000;
const grid = document.getElementById('grid');
const summary = document.getElementById('summary');
const shown = new Map();

function addCamera(camera) {
  const figure = document.getElementById('camera').content.firstElementChild.cloneNode(true);
  const image = figure.querySelector('img');
  image.alt = 'Live picture of camera ' + camera.name;
  [image.width, image.height] = camera.size;
  image.style.height = 'auto';
  figure.querySelector('a').href = camera.urls.stream;
  figure.querySelector('b').textContent = camera.name;
  grid.append(figure);
  const entry = { figure, image, mode: 'none', key: '' };
  // A stream that ends (camera changed, server restarted) is opened again by the next look.
  image.addEventListener('error', () => { entry.mode = 'none'; });
  shown.set(camera.name, entry);
  return entry;
}

function stop(entry) {
  if (entry.mode !== 'none') entry.image.removeAttribute('src');
  entry.mode = 'none';
}

function show(cameras) {
  const names = new Set(cameras.map((camera) => camera.name));
  for (const [name, entry] of shown) {
    if (names.has(name)) continue;
    stop(entry);
    entry.figure.remove();
    shown.delete(name);
  }
  cameras.forEach((camera, index) => {
    const entry = shown.get(camera.name) || addCamera(camera);
    const key = camera.size.join('×') + ', ' + camera.fps + ' frames/s';
    if (entry.key !== key) { stop(entry); entry.key = key; }
    entry.figure.querySelector('span').textContent = key;
    const wanted = index < liveStreams ? 'stream' : 'snapshot';
    if (entry.mode === wanted) return;
    stop(entry);
    entry.mode = wanted;
    entry.url = wanted === 'stream' ? camera.urls.stream : camera.urls.jpeg;
    if (wanted === 'stream') entry.image.src = entry.url + '?t=' + Date.now();
  });
  summary.textContent = cameras.length === 1 ? '1 camera' : cameras.length + ' cameras';
}

async function look() {
  if (document.hidden) return;
  try {
    const reply = await fetch('cameras');
    const body = await reply.json();
    if (!reply.ok) throw new Error(body.error.message);
    show(body.cameras);
  } catch (problem) {
    summary.textContent = 'no answer from the rig: ' + problem.message;
  }
}

function nextSnapshots() {
  if (document.hidden) return;
  for (const entry of shown.values()) {
    if (entry.mode === 'snapshot' && (entry.image.complete || !entry.image.src)) entry.image.src = entry.url + '?t=' + Date.now();
  }
}

document.addEventListener('visibilitychange', () => {
  if (document.hidden) for (const entry of shown.values()) stop(entry);
  else look();
});
setInterval(look, lookAgainMs);
setInterval(nextSnapshots, snapshotMs);
look();
