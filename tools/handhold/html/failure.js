// What goes wrong in the page stands in the page. Before all other scripts, and on its own.
window.addEventListener("error", (event) => {
  const root = document.documentElement;
  root.dataset.error = `${event.message} (line ${event.lineno})`;
  root.dataset.state = "failed";
  const message = document.getElementById("message");
  message.textContent = `This page has failed: ${event.message}`;
  message.hidden = false;
});
window.addEventListener("unhandledrejection", (event) => {
  document.documentElement.dataset.error = String(event.reason);
});
