// Commands are copied at a click, or done where they have a button; the list is made anew when the book has a new entry.
import { byId, onChange, post } from "/static/common.js";

document.querySelectorAll("[data-copy]").forEach((button) => button.addEventListener("click", async () => {
  await navigator.clipboard.writeText(button.dataset.copy);
  button.textContent = "copied";
  setTimeout(() => { button.textContent = "copy"; }, 1500);
}));

const forms = [...document.querySelectorAll("[data-finding]")].filter((form) => form.querySelector(".mend"));
const saidAt = (form) => form.querySelector("[role=alert]");
// A reason that is being written, what is under way, and what was refused would be lost.
const inUse = (form) => form.isConnected && (form.elements.why?.value || form.querySelector(".mend").disabled || saidAt(form).textContent);
forms.forEach((form) => form.addEventListener("submit", async (event) => {
  event.preventDefault();
  const button = form.querySelector(".mend");
  button.disabled = true;
  saidAt(form).textContent = "";
  try {
    await post("/api/mending", { ...JSON.parse(form.dataset.finding), day: byId("title").dataset.day, why: form.elements.why?.value });
    if (forms.some((other) => other !== form && inUse(other))) form.closest("li").remove(); else location.reload();
  } catch (error) {
    saidAt(form).textContent = error.status ? error.message : "no answer from labbook";
    button.disabled = false;
  }
}));

let quiet = null;
const again = onChange(() => {
  if (forms.some(inUse)) throw Object.assign(new Error("the book has new entries: reload the page"), { status: 409 });
  clearTimeout(quiet);  // once nothing more comes in: it takes a while to look at a large book
  quiet = setTimeout(() => (forms.some(inUse) ? again() : location.reload()), 1000);
});
