// Remember which stretches of the record were selected, in the loop or over time.
if (full.tags[1] !== "drawing") {
  const stretches = [];
  let last = -2;
  for (const index of Array.from(shown.selected.indices).sort((p, q) => p - q)) {
    const place = shown.data.place[index];
    if (index === last + 1) stretches[stretches.length - 1][1] = place;
    else stretches.push([place, place]);
    last = index;
  }
  full.tags = [stretches];
}
