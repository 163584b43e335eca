/** Runs in the page: what overflows the window or is cut. Scrolled panels may be longer than they are shown. */
export function clipped() {
  const found = [];
  const { scrollWidth, scrollHeight, clientWidth, clientHeight } = document.documentElement;
  if (scrollWidth > clientWidth || scrollHeight > clientHeight || scrollX || scrollY) found.push("the window scrolls");
  if (document.body.scrollHeight > document.body.clientHeight) found.push("the body scrolls");
  const all = document.querySelectorAll("button, label, h1, h2, h3, dt, dd, option, .option-label, .brief, .banner");
  for (const element of all) {
    const { display, visibility } = getComputedStyle(element);
    const isSeen = display !== "none" && display !== "inline" && visibility !== "hidden" && element.clientWidth > 1;
    if (!isSeen || !element.textContent.trim()) continue;
    const name = `${element.tagName.toLowerCase()}.${element.className} "${element.textContent.trim().slice(0, 40)}"`;
    if (element.scrollWidth > element.clientWidth) found.push(`${name} is cut`);
    const box = element.getBoundingClientRect();
    if (box.left < 0 || box.right > innerWidth) found.push(`${name} is beside the window`);
  }
  return found;
}

/** Runs in the page: controls without a name. */
export function nameless() {
  const named = (id) => document.getElementById(id)?.textContent;
  const nameOf = (element) =>
    element.getAttribute("aria-label") ||
    element.getAttribute("aria-labelledby")?.split(" ").map(named).join("") ||
    [...(element.labels ?? [])].map((label) => label.textContent).join("") ||
    (element.matches("button, a, summary, [role=menuitem]") ? element.textContent : "");
  const all = document.querySelectorAll("button, input, select, textarea, a, canvas, [role], [tabindex='0'], dialog");
  const needs = (element) => !["presentation", "alert", "status", "menu"].includes(element.getAttribute("role"));
  const isHidden = (element) => element.closest("[aria-hidden=true]") !== null;
  return [...all]
    .filter((element) => needs(element) && !isHidden(element) && !nameOf(element)?.trim())
    .map((element) => element.outerHTML.slice(0, 120));
}
