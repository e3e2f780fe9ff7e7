// Saves the muscles: shows the difference of the files first. A page from disk offers the file as a download.

class Saving {
  constructor(editor) {
    this.editor = editor;
    this.digest = editor.data.digest;
    this.box = element("div", document.body, { className: "dialog", hidden: true, role: "dialog", ariaLabel: "save muscles" });
    this.title = element("h2", this.box);
    this.note = element("p", this.box, { className: "bound" });
    this.text = element("pre", this.box, { tabIndex: 0 });
    this.buttons = element("div", this.box, { className: "buttons" });
  }

  get isOpen() { return !this.box.hidden; }
  close() { this.box.hidden = true; }

  async open() {
    const { editor } = this;
    try {
      if (editor.server.exists) await this.preview();
      else {
        this.show(this.fileName, "This page has no server; download the file and put it beside the robot.", muscleTableText(editor.document.data));
        this.addDownload();
      }
    } catch (error) {
      editor.fail(error.message);
    }
  }

  async preview() {
    const { editor } = this, { diff, path, conflict, error } = await editor.server.save({ document: editor.document.data, write: false, digest: this.digest });
    if (error) throw new Error(error);
    if (!diff && !conflict) {
      editor.say(`${path} already has these muscles; nothing to save`);
      return;
    }
    this.show(`Save ${path}`, conflict || "", diff);
    if (conflict) this.addDownload();
    else this.addChoices("Write", () => this.write());
  }

  async write() {
    const { editor } = this;
    try {
      const answer = await editor.server.save({ document: editor.document.data, write: true, digest: this.digest });
      const problem = answer.conflict || answer.error;
      if (problem) {
        this.note.textContent = problem;
        return;
      }
      this.digest = answer.digest;
      editor.document.markSaved();
      this.close();
      editor.say(`wrote ${answer.path}`);
    } catch (error) {
      this.note.textContent = error.message;
    }
  }

  // Returns the name of the file that the robot's reader finds beside the robot.
  get fileName() { return Object.keys(this.editor.data.files)[0] ?? "muscles.csv"; }

  addChoices(name, act) {
    addButton(this.buttons, name, act).className = "main";
    addButton(this.buttons, "Cancel", () => this.close());
  }

  addDownload() {
    const { editor, fileName } = this;
    this.addChoices("Download", () => {
      save(new Blob([muscleTableText(editor.document.data)], { type: "text/plain" }), fileName);
      editor.document.markSaved();
      this.close();
      editor.say(`downloaded ${fileName}; put it beside the robot`);
    });
  }

  // Shows lines of a difference with colours.
  show(title, note, text) {
    this.title.textContent = title;
    this.note.textContent = note;
    this.text.replaceChildren();
    for (const line of text.split(/\r?\n/)) {
      const kind = /^(\+\+\+|---|@@)/.test(line) ? "dim" : line[0] === "+" ? "added" : line[0] === "-" ? "removed" : "";
      element("span", this.text, { textContent: `${line}\n`, className: kind });
    }
    this.buttons.replaceChildren();
    this.box.hidden = false;
  }
}
