// Commands are copied at a click; the list is made anew when the book has a new entry.
import { onChange } from "/static/common.js";

document.querySelectorAll("[data-copy]").forEach((button) => button.addEventListener("click", async () => {
  await navigator.clipboard.writeText(button.dataset.copy);
  button.textContent = "copied";
  setTimeout(() => { button.textContent = "copy"; }, 1500);
}));
onChange(() => location.reload());
