// Opens a file of the user, chosen in the browser's dialog or dropped on the page. It is read here
// and never sent.
import { element } from "../page/dom";

export class FileOpener {
  readonly input = element("input", "file");

  constructor(opened: (file: File) => void) {
    this.input.type = "file";
    this.input.accept = ".json,application/json";
    this.input.hidden = true;
    this.input.addEventListener("change", () => {
      const file = this.input.files?.[0];
      this.input.value = "";  // the same file may be chosen again, written anew
      if (file) opened(file);
    });
    window.addEventListener("dragover", (event) => {
      if (!event.dataTransfer?.types.includes("Files")) return;
      event.preventDefault();
      document.body.classList.add("dropping");
    });
    window.addEventListener("dragleave", (event) => {
      if (event.relatedTarget === null) document.body.classList.remove("dropping");
    });
    window.addEventListener("drop", (event) => {
      document.body.classList.remove("dropping");
      const file = event.dataTransfer?.files[0];
      if (!file) return;
      event.preventDefault();
      opened(file);
    });
  }

  openDialog(): void { this.input.click(); }
}
