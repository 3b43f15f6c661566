// What is chosen on a page stands in its address.
export const addressed = () => Object.fromEntries(new URLSearchParams(location.hash.slice(1)));

export function writeAddress(state, fixed) {
  const told = Object.entries(state).filter(([key, value]) => String(value) !== String(fixed[key] ?? ""));
  history.replaceState(null, "", told.length ? `#${new URLSearchParams(told)}` : location.pathname + location.search);
}
