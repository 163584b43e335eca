/** Text of the server, with the names that it quotes in backticks. */
export function Words({ text }: { text: string }) {
  const parts = text.split("`");
  return <>{parts.map((part, i) => (i % 2 === 1 ? <code class="words-code">{part}</code> : part))}</>;
}
