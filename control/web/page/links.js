// Where programs find the camera that is shown large: addresses and lines to copy.
import { listen, selectedCamera, state } from './state.js';
import { forgetKey } from './key.js';
import { tell } from './messages.js';

const list = document.getElementById('link-list');
let shown = '';

// A page opened with a token keeps it in a cookie that scripts cannot read; the address bar and the links stay without.
const address = new URL(location.href);
if (address.searchParams.has('token')) {
  sessionStorage.setItem('camrig-token-asked', '1');
  forgetKey();
  address.searchParams.delete('token');
  history.replaceState(null, '', address);
}
const tokenAsked = sessionStorage.getItem('camrig-token-asked') === '1';

function linksOf(camera) {
  const query = tokenAsked ? '?token=TOKEN' : '';
  const base = `${location.origin}/cameras/${camera.name}/`;
  const mjpeg = `${base}stream.mjpg${query}`;
  const links = [['MJPEG', mjpeg], ['OpenCV', `cv2.VideoCapture("${mjpeg}")`]];
  if (state.info?.rtsp) {
    const user = tokenAsked ? 'camrig:TOKEN@' : '';
    links.push(['RTSP', `${state.info.rtsp_scheme ?? 'rtsp'}://${user}${location.hostname}:${state.info.rtsp}/${camera.name}`]);
  }
  for (const output of camera.outputs) if (output.number !== undefined) {
    const device = `/dev/video${output.number}`;
    links.push([output.kind === 'v4l2' ? 'V4L2' : 'Device', device]);
    if (output.kind === 'device') links.push(['With it', `camrig exec -- ffplay ${device}`]);
  }
  links.push(['Snapshot', `${base}snapshot.png${query}`], ['Calibration', `camrig camera calibration ${camera.name} -o ${camera.name}.yaml`]);
  return links;
}

async function copy(text, element) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    // Beyond localhost plain HTTP has no clipboard; the older way works from a click.
    getSelection().selectAllChildren(element);
    if (!document.execCommand('copy')) { tell('press Ctrl-C to copy what is selected'); return; }
  }
  tell(`copied: ${text}`, 'note');
}

function show() {
  const camera = selectedCamera();
  const links = camera ? linksOf(camera) : [];
  const key = JSON.stringify(links);
  if (key === shown) return;
  shown = key;
  list.replaceChildren(...links.flatMap(([label, text]) => {
    const term = document.createElement('dt');
    term.textContent = label;
    const details = document.createElement('dd');
    const code = document.createElement('code');
    code.textContent = text;
    code.title = text;
    const button = document.createElement('button');
    button.type = 'button';
    button.textContent = 'Copy';
    button.setAttribute('aria-label', `Copy ${label}: ${text}`);
    button.addEventListener('click', () => copy(text, code));
    details.append(code, button);
    return [term, details];
  }));
}
listen(show);
