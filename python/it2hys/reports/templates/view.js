// Draw of all samples those that show: of every pixel of the time axis the least and the greatest of each
// signal, so that no peak is hidden, and some spread evenly for the loop. Runs when the time axis moves.
// full, shown: ColumnDataSource; range: of the time axes; plot: whose width counts
const times = full.data.t;
const names = ["u", "y", "b", "a", "eb", "ea", "ib", "ia"];

const firstFrom = (time) => {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] < time) low = middle + 1;
    else high = middle;
  }
  return low;
};

const placesToShow = (first, end) => {
  const pixels = Math.max(200, Math.round(plot.inner_width || 800));
  const count = end - first;
  if (count <= 4 * pixels) return Array.from({ length: count }, (_, k) => first + k);
  const places = new Set([first, end - 1]);
  const step = Math.max(1, Math.floor(count / (3 * pixels)));
  for (let k = first; k < end; k += step) places.add(k);
  for (const name of names) {
    const values = full.data[name];
    for (let pixel = 0; pixel < pixels; pixel++) {
      const begin = first + Math.floor((count * pixel) / pixels);
      const stop = first + Math.floor((count * (pixel + 1)) / pixels);
      let least = -1;
      let greatest = -1;
      for (let k = begin; k < stop; k++) {
        const value = values[k];
        if (Number.isNaN(value)) continue;
        if (least < 0 || value < values[least]) least = k;
        if (greatest < 0 || value > values[greatest]) greatest = k;
      }
      if (least >= 0) places.add(least).add(greatest);
    }
  }
  return Array.from(places).sort((p, q) => p - q);
};

const draw = () => {
  // a sample more on either side, so that the line reaches the edge
  const first = Math.max(0, firstFrom(range.start) - 1);
  const end = Math.min(times.length, firstFrom(range.end) + 1);
  if (end - first < 2) return;
  const places = placesToShow(first, end);
  const data = { place: Int32Array.from(places) };
  for (const name of ["t", ...names]) {
    const values = full.data[name];
    data[name] = Float64Array.from(places, (k) => values[k]);
  }
  // what was selected stays so: stretches of samples that were neighbours when they were
  const stretches = full.tags[0] || [];
  const inside = (k) => stretches.some(([from, to]) => from <= k && k <= to);
  full.tags = [stretches, "drawing"];
  shown.data = data;
  shown.selected.indices = stretches.length
    ? Array.from(places.keys()).filter((i) => inside(places[i]))
    : [];
  full.tags = [stretches];
};

if (full.waits) cancelAnimationFrame(full.waits);
full.waits = requestAnimationFrame(draw);
