const FIELD = ".mantine-NumberInput-input";
const NUMBER = /^[-+]?(\d+[.,]?\d*|[.,]\d+)(e[-+]?\d+)?$/i;

/** What a pasted text means in a number field, with a decimal point; null where it is not one number. */
export function pastedNumber(text: string): string | null {
  const plain = text.trim().replace("\u2212", "-");
  return NUMBER.test(plain) ? plain.replace(",", ".").replace(/^\+/, "") : null;
}

/** Have every number field take "0,5" for 0.5, and say what it cannot take: left alone, it drops what it does not know. */
export function hearPastes(page: Document, say: (text: string) => void): void {
  const paste = (event: ClipboardEvent) => {
    if (!(event.target instanceof HTMLInputElement) || !event.target.matches(FIELD)) return;
    const text = event.clipboardData?.getData("text") ?? "";
    const number = pastedNumber(text);
    event.preventDefault();
    event.stopPropagation();
    if (number === null)
      say(`"${text.slice(0, 40)}" is not a number with one decimal mark: the field keeps its own`);
    else page.execCommand("insertText", false, number); // eslint-disable-line @typescript-eslint/no-deprecated -- nothing else keeps undo
  };
  page.addEventListener("paste", paste, { capture: true });
}
