// What can be saved.

/** @param {string} name @param {import("./module/imulab.js").Content} content */
export function saveButton(name, content) {
  const onclick = () => {
    const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(new Blob([/** @type {BlobPart} */ (content)])), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  };
  return Object.assign(document.createElement("button"), { textContent: `Save ${name}`, type: "button", onclick });
}
