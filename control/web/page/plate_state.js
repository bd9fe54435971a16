// What the page of photos knows: the photo, what was clicked in it, the camera that was found, shapes and light. change() alone changes it, and tells
// all who show it; lists are made anew, so that who keeps what he showed last sees what is new.

export const plate = {
  photo: null,      // {bitmap, size, file: its name, camera: of the rig, or null}
  tool: 'point',
  drawing: [],      // pixels of what is being drawn
  points: [],       // as plate.calibrate takes them; m: null until it is told
  heights: [],
  lines: [],
  known: {},        // vfov_deg, click_px, camera_height_m, fit_k1
  found: null,      // what plate.calibrate answered; of a camera of the rig `camera` and `ground` alone
  isStale: false,   // clicks were changed since
  problem: null,    // {of: 'points[2]', text}
  shapes: [],       // {kind, px, height_m, role}; of a cut-out the last pixel is its foot
  groundRole: null, // of the level ground; null: as it has it
  measured: [],     // {kind: distance | standing, px: two pixels}
  figure: null,     // {px} or {m}: where it was put
  shown: {},        // of plate_view.js: where the camera shows all that is in metres
  sun: { azimuth_deg: 150, elevation_deg: 40, sun: 1, sky: 1 },
  light: null,      // what plate.light answered
};
const listeners = new Set();

export function listen(fn) { listeners.add(fn); }

export function change(values) {
  Object.assign(plate, values);
  for (const fn of listeners) fn(plate);
}

/** Changes what is calibrated from: what was found before is no longer of it. */
export function changeClicks(values) { change({ ...values, problem: null, isStale: true }); }

/** A list with one member changed (undefined: left out). */
export function withOne(list, index, value) { return value === undefined ? list.toSpliced(index, 1) : list.with(index, value); }

/** All pixels that can be dragged: of what they are, where, and how to move them. */
export function handles() {
  const of = (list, name, keys, set) => plate[list].flatMap((one, index) => keys.map((key) => ({
    of: `${name}[${index}]`, px: one[key], move: (px) => set({ [list]: withOne(plate[list], index, { ...one, [key]: px }) }),
  })));
  return [
    ...of('points', 'points', ['px'], changeClicks),
    ...of('heights', 'heights', ['foot_px', 'head_px'], changeClicks),
    ...of('lines', 'lines', ['from_px', 'to_px'], changeClicks),
    ...plate.measured.flatMap((one, index) => one.px.map((end, place) => ({
      of: `measured[${index}]`, px: end,
      move: (px) => change({ measured: withOne(plate.measured, index, { ...one, px: one.px.with(place, px) }) }),
    }))),
    ...plate.shapes.flatMap((shape, index) => shape.px.map((corner, place) => ({
      of: `shapes[${index}]`, px: corner,
      move: (px) => change({ shapes: withOne(plate.shapes, index, { ...shape, px: shape.px.with(place, px) }), problem: null }),
    }))),
  ];
}
