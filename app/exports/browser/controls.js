// What keys, buttons and the pointer do.

function listen(viewer) {
  const slider = document.getElementById("time"), play = document.getElementById("play"), start = scene.start ?? 0;
  let playing = false, before = 0, due = false;
  const show = () => {
    slider.value = viewer.time;
    const frame = Math.min(scene.frames - 1, Math.round(viewer.time * scene.frames));
    document.getElementById("frame").textContent = `frame ${start + frame + 1} / ${start + scene.frames}`;
    if (!due) { due = true; requestAnimationFrame(step); }
  };
  const step = (now) => {
    due = false;
    if (playing) {
      // The frame may have begun before the click that plays it.
      viewer.time = (viewer.time + Math.max(now - before, 0) / 1000 / scene.seconds) % 1;
      before = now;
    }
    viewer.draw();
    if (playing) show();
  };
  const toggle = () => {
    playing = !playing;
    before = performance.now();
    play.textContent = playing ? "❚❚" : "▶";
    play.setAttribute("aria-label", playing ? "Pause" : "Play");
    show();
  };
  const move = (by) => { viewer.time = Math.min(1, Math.max(0, viewer.time + by / scene.frames)); show(); };
  play.onclick = toggle;
  slider.oninput = () => { viewer.time = Number(slider.value); show(); };
  document.getElementById("reset").onclick = canvas.ondblclick = () => { viewer.reset(); show(); };
  window.onresize = show;
  window.onkeydown = (event) => {
    const deeds = { " ": toggle, arrowleft: () => move(-1), arrowright: () => move(1), r: () => { viewer.reset(); show(); } };
    const deed = deeds[event.key.toLowerCase()];
    if (!deed || event.ctrlKey || event.metaKey || event.altKey || event.target.tagName === "BUTTON" && event.key === " ") return;
    event.preventDefault();
    deed();
  };
  canvas.onwheel = (event) => { event.preventDefault(); viewer.zoom(Math.exp(event.deltaY * 0.001)); show(); };
  const held = new Map();
  canvas.onpointerdown = (event) => { canvas.setPointerCapture(event.pointerId); held.set(event.pointerId, event); };
  canvas.onpointerup = canvas.onpointercancel = (event) => held.delete(event.pointerId);
  canvas.onpointermove = (event) => {
    const last = held.get(event.pointerId);
    if (!last) return;
    const across = event.clientX - last.clientX, down = event.clientY - last.clientY;
    if (held.size === 2) {
      const other = [...held.values()].find((one) => one.pointerId !== event.pointerId);
      const far = (one) => Math.hypot(one.clientX - other.clientX, one.clientY - other.clientY) || 1;
      viewer.zoom(far(last) / far(event));
    } else if (event.shiftKey || event.buttons & 2) {
      const step = viewer.middle / (clipLens(viewer.time)[0] * Math.min(canvas.clientWidth / scene.camera.width, canvas.clientHeight / scene.camera.height));
      viewer.pan(across * step, down * step);
    } else {
      viewer.orbit(across * 0.005, -down * 0.005);
    }
    held.set(event.pointerId, event);
    show();
  };
  canvas.oncontextmenu = (event) => event.preventDefault();
  show();
}
