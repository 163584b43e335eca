// Whether pictures are drawn by the processor.

const NAMES = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** By the name of what draws, which a canvas of its own tells: that of the view is made with the answer. */
export function isSoftware(): boolean {
  const context = document.createElement("canvas").getContext("webgl2");
  if (!context) return false;
  const names = context.getExtension("WEBGL_debug_renderer_info");
  const name = String(context.getParameter(names?.UNMASKED_RENDERER_WEBGL ?? context.RENDERER));
  context.getExtension("WEBGL_lose_context")?.loseContext();
  return NAMES.test(name);
}
