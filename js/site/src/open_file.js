// Files that the user drops on the page or chooses. They are read by the page and go nowhere.

const hasFiles = ({ dataTransfer }) => dataTransfer?.types.includes("Files") ?? false;

/** button opens the dialog of input; veil is shown while a file is over the page; play(file). */
export function openFiles({ button, input, veil, play }) {
  button.addEventListener("click", () => input.click());
  input.addEventListener("change", () => {
    const [file] = input.files;
    // The same file can be chosen again.
    input.value = "";
    if (file) play(file);
  });
  let inside = 0; // elements that the pointer has entered and not left
  const show = (change) => {
    inside = change ? Math.max(0, inside + change) : 0;
    veil.hidden = inside === 0;
  };
  addEventListener("dragenter", (event) => hasFiles(event) && show(1));
  addEventListener("dragleave", (event) => hasFiles(event) && show(-1));
  addEventListener("dragover", (event) => hasFiles(event) && event.preventDefault());
  addEventListener("drop", (event) => {
    if (!hasFiles(event)) return;
    event.preventDefault();
    show(0);
    const [file] = event.dataTransfer.files;
    if (file) play(file);
  });
}
