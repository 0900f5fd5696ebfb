// What is to be done with the frame that comes next: the one place that decides between showing, waiting and dropping.

/** Seconds that a frame may come early: half a picture of a screen, else it comes a whole one late. */
const EARLY = 0.004;
/** Milliseconds after which a late frame is shown all the same: a slow picture beats none. */
const LONGEST_BLANK = 250;
/** Seconds, not of the stream, that decoding may lag before frames are leapt over. */
const LAG = 0.5;

/**
 * frame: {seconds, duration}, position: of the clock. sinceShown: milliseconds. Answers
 *   "wait"  it is not due        "show"  it is
 *   "drop"  the next one is due already
 *   "lag"   decoding does not keep up: leap, or set the clock back
 */
export function whatIsDue(frame, position, rate, sinceShown) {
  const late = position - frame.seconds;
  if (late < -EARLY * rate) return "wait";
  if (late > LAG * rate && late > frame.duration) return "lag";
  if (late > frame.duration && sinceShown < LONGEST_BLANK) return "drop";
  return "show";
}
