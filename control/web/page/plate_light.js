// Sun and sky of the photo: the rig says what light they give (plate.light), sliders how strong it is. The figure's shadow shows it at once.
import { call } from './rpc.js';
import { change, listen, plate } from './plate_state.js';
import { attempt } from './messages.js';

const form = document.getElementById('light');
const sliders = ['azimuth_deg', 'elevation_deg', 'sun', 'sky'];
let wish = null;      // the newest question
let isAsking = false;

/** Asks for a sun, the newest question next. */
async function ask(question) {
  wish = question;
  if (isAsking) return;
  isAsking = true;
  while (wish) {
    const now = wish;
    wish = null;
    const light = await attempt(() => call('plate.light', now));
    if (!light) continue;
    const { azimuth_deg, elevation_deg } = light;
    // What is dragged on meanwhile is ahead of this answer.
    change({ light, ...(now.sun ? {} : { sun: { ...plate.sun, azimuth_deg, elevation_deg } }) });
  }
  isAsking = false;
}

/** The tool's three pixels: top, foot and tip of the shadow. */
export function shadowClicked([top_px, foot_px, tip_px]) {
  attempt(async () => {
    if (!plate.found) throw new Error('shadow: calibrate the photo first');
    await ask({ shadow: { top_px, foot_px, tip_px }, camera: plate.found.camera });
  });
}

/** `lights` and `environment` of a scene, as strong as the sliders say. */
export function sceneLight() {
  const { lights, environment } = plate.light;
  const scaled = (color) => color.map((part) => part * plate.sun.sky);
  const { sky, ground } = environment.ambient;
  return {
    environment: { ambient: { sky: scaled(sky), ground: scaled(ground) } },
    lights: [{ ...lights[0], intensity: lights[0].intensity * plate.sun.sun }],
  };
}

form.addEventListener('input', ({ target }) => {
  if (!sliders.includes(target.name)) return;
  change({ sun: { ...plate.sun, [target.name]: Number(target.value) } });
  if (target.name.endsWith('_deg')) ask({ sun: [plate.sun.azimuth_deg, plate.sun.elevation_deg] });
});
form.addEventListener('submit', (event) => {
  event.preventDefault();
  const place = form.elements.place.value.split(/[\s,]+/).filter((part) => part !== '').map(Number);
  ask({ time: form.elements.time.value.trim(), place });
});
listen(({ sun }) => {
  for (const name of sliders) {
    form.elements[name].value = sun[name];
    form.querySelector(`output[data-of=${name}]`).textContent = name.endsWith('_deg') ? `${Math.round(sun[name])}°` : `× ${Number(sun[name]).toFixed(2)}`;
  }
});
ask({ sun: [plate.sun.azimuth_deg, plate.sun.elevation_deg] });
