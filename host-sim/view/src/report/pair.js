(() => {
  const { difference, meanings, runs } = JSON.parse(document.getElementById("data").textContent);
  const names = ["A", "B"];
  // One colour a run, in the map and in every curve.
  const hues = ["estimate", "moving"];

  // ---- time ----
  const all = runs.flatMap(({ series }) => [series.t_s[0] ?? 0, series.t_s[series.t_s.length - 1] ?? 1]);
  const begin = Math.min(...all);
  const span = [begin, Math.max(Math.max(...all), begin + 1e-6)];
  const slider = byId("time");
  let now = span[1];
  const rowAt = ({ t_s: times }, t) => {
    let [low, high] = [0, times.length - 1];
    while (low < high) {
      const middle = Math.ceil((low + high) / 2);
      if (times[middle] <= t) low = middle; else high = middle - 1;
    }
    return low;
  };
  const go = (t) => {
    now = Math.min(span[1], Math.max(span[0], t));
    slider.value = 1000 * (now - span[0]) / (span[1] - span[0]);
    const errors = runs.map(({ series }, k) => names[k] + " " + figure(series.position_error_m[rowAt(series, now)], 3) + " m");
    byId("clock").textContent = now.toFixed(2) + " s; error " + errors.join(", ");
    drawMap();
    curves.forEach((draw) => draw());
  };
  slider.addEventListener("input", () => go(span[0] + slider.value / 1000 * (span[1] - span[0])));

  // ---- map ----
  const map = byId("map");
  const shows = {};
  const has = (key) => runs.some(({ series }) => series[key].some(Boolean));
  for (const [name, text, there, on] of [["truth", "truth", has("truth"), true], ["reckoned", "dead reckoning", true, false],
    ["features", "features", true, true], ["landmarks", "true landmarks", runs.some((run) => run.landmarks.length > 0), true]]) {
    if (!there) continue;
    const label = make("label", byId("shows"));
    shows[name] = make("input", label);
    shows[name].type = "checkbox";
    shows[name].checked = on;
    label.append(" " + text);
    shows[name].addEventListener("change", drawMap);
  }
  const on = (name) => shows[name] !== undefined && shows[name].checked;
  const look = runs[0].looks[0];
  const axes = runs[0].axes;
  let view = { x: 0, y: 0, scale: 1 };
  const showAll = () => {
    const points = runs.flatMap(({ series, landmarks }) => [...series.position, ...series.truth.filter(Boolean), ...landmarks]);
    view = viewOf(map, look.map((axis) => {
      let [low, high] = [Infinity, -Infinity];
      for (const p of points) { low = Math.min(low, p[axis]); high = Math.max(high, p[axis]); }
      const margin = 0.04 * (high - low) + 0.5;
      return [low - margin, high + margin];
    }));
    drawMap();
  };
  function drawMap() {
    const [c, width, height] = context(map);
    const [i, j] = look;
    const X = (p) => width / 2 + (p[i] - view.x) * view.scale;
    const Y = (p) => height / 2 - (p[j] - view.y) * view.scale;
    drawGrid(c, width, height, view, look.map((axis) => axes[axis]));
    const path = (points, until, colour, dash) => {
      c.strokeStyle = colour;
      c.lineWidth = 1.5;
      c.setLineDash(dash);
      c.beginPath();
      let pen = false;
      for (let k = 0; k <= until; k++) {
        const p = points[k];
        if (!p) { pen = false; continue; }
        if (pen) c.lineTo(X(p), Y(p)); else c.moveTo(X(p), Y(p));
        pen = true;
      }
      c.stroke();
      c.setLineDash([]);
    };
    if (on("landmarks")) {
      c.strokeStyle = colours.landmark;
      c.lineWidth = 1.4;
      c.beginPath();
      for (const p of runs[0].landmarks) {
        const [x, y] = [X(p), Y(p)];
        c.moveTo(x - 5, y); c.lineTo(x + 5, y);
        c.moveTo(x, y - 5); c.lineTo(x, y + 5);
      }
      c.stroke();
    }
    const rows = runs.map(({ series }) => rowAt(series, now));
    if (on("truth")) path(runs[0].series.truth, rows[0], colours.truth, [2, 3]);
    runs.forEach(({ series, last }, k) => {
      const colour = colours[hues[k]];
      if (on("reckoned")) path(series.dead_reckoning, rows[k], k === 0 ? colours.reckoned : colour, [5, 4]);
      path(series.position, rows[k], colour, []);
      if (on("features") && last) {
        c.strokeStyle = colour;
        c.lineWidth = 1.2;
        for (const feature of [...last.features, ...last.moving]) {
          const [x, y] = [X(feature[2]), Y(feature[2])];
          c.beginPath();
          if (k === 0) c.arc(x, y, 3.5, 0, 2 * Math.PI); else c.rect(x - 4, y - 4, 8, 8);
          c.stroke();
        }
      }
      const here = series.position[rows[k]];
      if (here) {
        c.fillStyle = colour;
        c.beginPath();
        c.arc(X(here), Y(here), 6, 0, 2 * Math.PI);
        c.fill();
        c.fillStyle = colours.ink;
        c.fillText(names[k], X(here) + 8, Y(here) - 6);
      }
    });
  }
  const zoom = movable(map, () => view, drawMap, () => {});
  map.addEventListener("dblclick", showAll);

  // ---- curves: what both have in one plot ----
  const curves = [];
  const both = (key) => runs.map((_, k) => [names[k], k, key, hues[k], true]);
  const plots = [
    ["position error (m)", [...both("position_error_m"), ["2σ of A", 0, "position_2sigma_m", "particle", false],
      ["2σ of B", 1, "position_2sigma_m", "missed", false], ["dead reckoning", 0, "dead_reckoning_error_m", "reckoned", false]]],
    ["heading error (deg)", both("heading_error_deg")],
    ["OSPA of the map (m)", both("ospa_m")],
    ["the filter's own 2σ of the position (m)", both("position_2sigma_m")],
    ["features estimated", both("features_estimated")],
    ["effective particles", both("n_eff")],
    ["time of a scan (µs)", both("scan_us")],
  ];
  for (const [name, lines] of plots) {
    const known = lines.filter(([, k, key]) => runs[k].series[key].some((v) => v !== null));
    if (known.every(([, , , , usual]) => !usual)) continue;
    const head = make("div", byId("curves"));
    head.className = "curve-name";
    make("b", head, name);
    const hidden = new Set();
    for (const line of known) {
      const label = make("label", head);
      const box = make("input", label);
      box.type = "checkbox";
      box.checked = line[4];
      if (!box.checked) hidden.add(line);
      make("i", label).style.background = "var(--" + line[3] + ")";
      label.append(line[0]);
      box.addEventListener("change", () => { if (box.checked) hidden.delete(line); else hidden.add(line); draw(); });
    }
    const read = make("span", head);
    read.className = "faint";
    const canvas = make("canvas", byId("curves"));
    canvas.className = "curve";
    const draw = () => {
      const [c, width, height] = context(canvas);
      const shown = known.filter((line) => !hidden.has(line));
      const X = drawChart(c, width, height, span, shown.map(([, k, key, colour]) => [runs[k].series.t_s, runs[k].series[key], colours[colour]]));
      c.strokeStyle = colours.ink;
      c.lineWidth = 1;
      c.beginPath();
      c.moveTo(X(now), 0);
      c.lineTo(X(now), height - CHART.bottom);
      c.stroke();
      read.textContent = shown.map(([text, k, key]) => text + " " + figure(runs[k].series[key][rowAt(runs[k].series, now)], 3)).join(", ");
    };
    let held = false;
    const pick = (e) => go(timeAt(canvas, span, e.offsetX));
    canvas.addEventListener("pointerdown", (e) => { held = true; pick(e); });
    canvas.addEventListener("pointermove", (e) => { if (held) pick(e); });
    for (const end of ["pointerup", "pointercancel", "pointerleave"]) canvas.addEventListener(end, () => { held = false; });
    curves.push(draw);
  }

  // ---- texts ----
  const figures = new Map(difference.figures.map((row) => [row.key, row]));
  for (const [key, text] of [["position_rmse_m", "position RMSE (m)"], ["heading_rmse_deg", "heading RMSE (deg)"],
    ["nees_median", "NEES/dim, median"], ["ospa_m", "OSPA of the final map (m)"], ["features_estimated", "features"], ["scan_us_mean", "scan, mean (µs)"]]) {
    const row = figures.get(key);
    if (!row) continue;
    const tile = make("div", byId("headline"));
    tile.className = "tile";
    const value = make("b", tile);
    [row.a, row.b].forEach((v, k) => {
      if (k > 0) value.append(" · ");
      make("span", value, figure(v, 3)).style.cssText = "font-size: inherit; color: var(--" + hues[k] + ")";
    });
    make("span", tile, text);
  }
  byId("inputs").textContent = difference.other_inputs.length === 0 ? "" : "These are not runs over the same inputs: " + difference.other_inputs.join("; ") + ".";
  byId("inputs").style.color = "var(--stray)";
  const plain = (value) => value === null ? "-" : typeof value === "string" ? value : JSON.stringify(value);
  const body = byId("settings").tBodies[0];
  for (const { setting, a, b } of difference.settings) {
    const row = make("tr", body);
    make("td", row, setting);
    for (const value of [a, b]) make("td", row, plain(value)).className = "number";
  }
  if (difference.settings.length === 0) make("td", make("tr", body), "none").colSpan = 3;
  const meaningOf = new Map(meanings);
  for (const { key, a, b, difference: off } of difference.figures) {
    const row = make("tr", byId("figures").tBodies[0]);
    make("td", row, key);
    // As written: every digit of the JSON output.
    for (const value of [a, b]) make("td", row, plain(value)).className = "number";
    make("td", row, off === null ? "" : figure(off)).className = "number";
    make("td", row, meaningOf.get(key) ?? "");
  }
  for (const [name, colour] of [["A: " + difference.runs[0] + ", features as rings", hues[0]], ["B: " + difference.runs[1] + ", features as squares", hues[1]],
    ["truth", "truth"], ["dead reckoning", "reckoned"], ["true landmark", "landmark"]]) {
    const item = make("span", byId("key"));
    make("i", item).style.background = "var(--" + colour + ")";
    item.append(name);
  }

  const redraw = () => { drawMap(); curves.forEach((draw) => draw()); };
  byId("theme").addEventListener("click", () => { setTheme(document.documentElement.dataset.theme === "dark" ? "light" : "dark"); redraw(); });
  document.addEventListener("keydown", (e) => {
    if (e.ctrlKey || e.metaKey || e.altKey || e.target.matches("input, button")) return;
    const rect = map.getBoundingClientRect();
    const step = (span[1] - span[0]) / 200;
    const keys = { ArrowLeft: () => go(now - step), ArrowRight: () => go(now + step), t: () => byId("theme").click(), 0: showAll,
      "+": () => zoom(1.25, rect.width / 2, rect.height / 2), "-": () => zoom(0.8, rect.width / 2, rect.height / 2) };
    if (!keys[e.key]) return;
    e.preventDefault();
    keys[e.key]();
  });
  const asked = new URLSearchParams(location.hash.slice(1));
  if (["dark", "light"].includes(asked.get("theme"))) setTheme(asked.get("theme"));
  addEventListener("resize", redraw);
  showAll();
  go(asked.has("t") ? Number(asked.get("t")) : span[1]);
  document.documentElement.dataset.ready = Math.round(performance.now());
})();
