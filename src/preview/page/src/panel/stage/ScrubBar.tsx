// Plays a cache of the simulation mesh, on it and on the render mesh.

import { Button, IconButton } from "../controls/controls";
import { useSelect, useStore } from "../controls/hooks";
import { Icon } from "../controls/icons";
import { neat } from "../controls/numbers";
import { Words } from "../controls/Words";

export function ScrubBar() {
  const store = useStore();
  const shot = useSelect((state) => state.shot);
  const isPlaying = useSelect((state) => state.isPlaying);
  if (!shot) return null;
  if (shot.fault) {
    const { place, text, remedy } = shot.fault;
    return (
      <p class="scrub-bar has-fault" role="alert">
        <Icon name="error" />
        <span>
          <b>{place}</b> <Words text={text} />{" "}
          <span class="remedy">
            <Words text={remedy} />
          </span>
        </span>
      </p>
    );
  }
  const { frames, frame, time } = shot;
  const last = frames - 1;
  return (
    <div class="scrub-bar" role="group" aria-label="Shot" title={shot.file}>
      <IconButton
        label={isPlaying ? "Pause" : "Play"}
        icon={isPlaying ? "pause" : "play"}
        hint={isPlaying ? "Pause (Space)" : "Play (Space)"}
        act={() => store.player.toggle()}
      />
      <input
        type="range"
        aria-label="Frame"
        aria-valuetext={time === null ? "at bind" : `time ${neat(time)}`}
        min={0}
        max={last}
        step={1}
        value={frame ?? 0}
        onInput={({ currentTarget }) => store.player.show(currentTarget.valueAsNumber)}
      />
      <output>{time === null ? "bind" : neat(time)}</output>
      <Button class="is-small" disabled={frame === null} act={() => store.player.show(null)}>Bind</Button>
    </div>
  );
}
