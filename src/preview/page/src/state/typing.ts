// Fields that keys of the page are typed into.

const NO_TEXT = ["range", "checkbox", "radio", "button"];

export function isTyping(target: EventTarget | null): boolean {
  if (target instanceof HTMLInputElement) return !NO_TEXT.includes(target.type);
  return target instanceof HTMLTextAreaElement || target instanceof HTMLSelectElement;
}
