// A report in the page: in a frame of its own origin, which runs the report's scripts and can reach neither this page nor any server.

/**
 * @param {HTMLElement} place gets the frame
 * @param {string | null} html
 * @param {{ lazy?: boolean }} [options] lazy: once a <details> is opened
 */
export function showReport(place, html, { lazy = false } = {}) {
  place.querySelector("iframe")?.remove();
  place.hidden = !html;
  if (!html) return;
  const load = () => {
    if (place.querySelector("iframe")) return;
    const frame = document.createElement("iframe");
    frame.title = "Report";
    frame.setAttribute("sandbox", "allow-scripts allow-downloads allow-modals");
    const listen = (/** @type {MessageEvent} */ event) => {
      if (event.source !== frame.contentWindow) return;
      if (event.data?.ready) frame.contentWindow?.postMessage(html, "*");
      if (typeof event.data?.height === "number") frame.height = String(Math.min(event.data.height + 4, 60000));
      if (!frame.isConnected) removeEventListener("message", listen);
    };
    addEventListener("message", listen);
    frame.src = "report.html";
    place.append(frame);
  };
  if (!lazy) return load();
  const details = /** @type {HTMLDetailsElement} */ (place);
  details.open = false;
  details.ontoggle = () => details.open && load();
}
