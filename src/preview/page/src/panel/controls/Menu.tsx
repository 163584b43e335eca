// A menu that opens below its button, with a field to find an item if there are many.

import type { ComponentChildren, TargetedKeyboardEvent } from "preact";
import { useLayoutEffect, useRef, useState } from "preact/hooks";
import { useOutside } from "./hooks";
import { Icon, type IconName } from "./icons";

export interface MenuItem {
  label: string;
  detail?: string;
  icon?: IconName;
  /** A colour chip, as CSS. */
  chip?: string;
  /** A drawing before the label. */
  picture?: ComponentChildren;
  /** Why the item cannot be used. */
  blocked?: string;
  danger?: boolean;
  /** Heading above the first item of a section. */
  section?: string;
  pick(): void;
  /** The pointer or the focus comes and goes. */
  hover?(on: boolean): void;
}

interface PopButtonProps {
  label: string;
  hint?: string;
  class?: string;
  disabled?: boolean;
  isMenu?: boolean;
  /** It is about to open. */
  opens?(): void;
  children: ComponentChildren;
  content(anchor: Anchor, close: (takesFocus: boolean) => void): ComponentChildren;
}

type Anchor = { current: HTMLElement | null };

/** A button with something that opens below it, until there is a press elsewhere. */
export function PopButton({ label, hint, class: name, disabled, isMenu, opens, children, content }: PopButtonProps) {
  const [isOpen, setOpen] = useState(false);
  const wrap = useRef<HTMLSpanElement>(null);
  const button = useRef<HTMLButtonElement>(null);
  const close = (takesFocus: boolean) => {
    setOpen(false);
    if (takesFocus) button.current?.focus();
  };
  useOutside(wrap, () => close(false));
  const keys = (event: TargetedKeyboardEvent<HTMLElement>) => {
    if (event.key !== "Escape" || !isOpen) return;
    event.stopPropagation();
    close(true);
  };
  return (
    <span class="menu-wrap" ref={wrap} onKeyDown={keys}>
      <button
        type="button"
        ref={button}
        class={name ?? "icon-button"}
        aria-label={label}
        aria-haspopup={isMenu ? "menu" : undefined}
        aria-expanded={isOpen}
        title={hint ?? label}
        disabled={disabled}
        onClick={() => (!isOpen && opens?.(), setOpen(!isOpen))}
      >
        {children}
      </button>
      {isOpen && content(button, close)}
    </span>
  );
}

/** Shows an element in the top layer below its anchor. */
export function usePopover(box: Anchor, anchor: Anchor): void {
  useLayoutEffect(() => {
    if (!box.current || !anchor.current) return;
    box.current.showPopover();
    place(box.current, anchor.current.getBoundingClientRect());
  }, []);
}

interface MenuButtonProps extends Omit<PopButtonProps, "content" | "isMenu"> {
  /** Words where there is nothing to choose from. */
  empty?: string;
  items(): MenuItem[];
}

export function MenuButton({ empty, items, ...button }: MenuButtonProps) {
  const list = (anchor: Anchor, close: (takesFocus: boolean) => void) => (
    <MenuList label={button.label} empty={empty} items={items()} anchor={anchor} close={close} />
  );
  return <PopButton {...button} isMenu content={list} />;
}

/** Items from which on a menu has a field to find one. */
const MANY = 7;

interface MenuListProps {
  label: string;
  empty?: string;
  items: MenuItem[];
  anchor: Anchor;
  close(takesFocus: boolean): void;
}

function MenuList({ label, empty, items, anchor, close }: MenuListProps) {
  const list = useRef<HTMLDivElement>(null);
  const [wish, setWish] = useState("");
  const hovered = useRef<MenuItem | null>(null);
  const hover = (item: MenuItem | null) => {
    if (hovered.current === item) return;
    hovered.current?.hover?.(false);
    hovered.current = item;
    item?.hover?.(true);
  };
  usePopover(list, anchor);
  useLayoutEffect(() => {
    if (list.current) focusable(list.current)[0]?.focus();
    return () => hover(null);
  }, []);
  const found = items.filter((item) => item.label.toLowerCase().includes(wish.trim().toLowerCase()));
  const keys = (event: TargetedKeyboardEvent<HTMLDivElement>) => {
    event.stopPropagation();
    if (event.key === "Escape") close(true);
    if (event.key === "Tab") close(false);
    if (event.key === "ArrowDown" || event.key === "ArrowUp") {
      event.preventDefault();
      step(event.currentTarget, event.key === "ArrowDown" ? 1 : -1);
    }
  };
  return (
    <div class="menu" popover="manual" ref={list} onKeyDown={keys} onPointerLeave={() => hover(null)}>
      {items.length > MANY && (
        <label class="menu-find">
          <Icon name="search" />
          <input
            type="text"
            placeholder="Find"
            aria-label={`Find in ${label}`}
            value={wish}
            onInput={({ currentTarget }) => setWish(currentTarget.value)}
            onKeyDown={(event) => {
              if (event.key !== "Enter" || !found[0] || found[0].blocked) return;
              // Or else the button, which has the focus by then, would open the menu again.
              event.preventDefault();
              close(true);
              found[0].pick();
            }}
          />
        </label>
      )}
      <div role="menu" aria-label={label} class="menu-items">
        {found.length === 0 && <p class="menu-empty">{wish ? "Nothing found" : (empty ?? "Nothing to choose from")}</p>}
        {found.map((item, i) => (
          <>
            {item.section && item.section !== found[i - 1]?.section && (
              <div class="menu-section" role="presentation">{item.section}</div>
            )}
            <Item item={item} hover={hover} pick={() => (close(true), item.pick())} />
          </>
        ))}
      </div>
    </div>
  );
}

function Item({ item, hover, pick }: { item: MenuItem; hover(item: MenuItem): void; pick(): void }) {
  return (
    <button
      type="button"
      role="menuitem"
      class={`menu-item ${item.danger ? "is-danger" : ""}`}
      aria-disabled={item.blocked !== undefined}
      title={item.blocked}
      onPointerEnter={() => hover(item)}
      onFocus={() => hover(item)}
      onClick={() => item.blocked === undefined && pick()}
    >
      {item.icon && <Icon name={item.icon} />}
      {item.picture}
      {item.chip && <i class="chip" style={{ background: item.chip }} />}
      <span class="menu-label">{item.label}</span>
      {(item.detail ?? item.blocked) && <span class="menu-detail">{item.detail ?? item.blocked}</span>}
    </button>
  );
}

function focusable(list: HTMLElement): HTMLElement[] {
  return [...list.querySelectorAll<HTMLElement>("input, button")];
}

function step(list: HTMLElement, by: number): void {
  const all = focusable(list);
  const at = all.indexOf(document.activeElement as HTMLElement);
  all[(at + by + all.length) % all.length]?.focus();
}

const MARGIN = 8;

/** Below the anchor, or above it where there is more room, and within the window. */
function place(menu: HTMLElement, anchor: DOMRect): void {
  const { width, height } = menu.getBoundingClientRect();
  const isBelow = anchor.bottom + height + MARGIN <= innerHeight || anchor.top < innerHeight - anchor.bottom;
  const top = isBelow ? anchor.bottom + 4 : anchor.top - height - 4;
  menu.style.left = `${Math.max(MARGIN, Math.min(anchor.left, innerWidth - width - MARGIN))}px`;
  menu.style.top = `${Math.max(MARGIN, Math.min(top, innerHeight - height - MARGIN))}px`;
}
