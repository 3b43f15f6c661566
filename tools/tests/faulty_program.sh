#!/bin/sh
# In place of the program: each tenth case ends badly the first time that it is asked for. A third of these is killed midway,
# a third finds no memory, a third a full disk. FAULTS: folder of the markers, with `program` (the real one) and `full` (no
# room). Everything else is the program's own.
set -e
program=$FAULTS/program
case $1 in run | replay) ;; *) exec "$program" "$@" ;; esac
out= asked= last=
for word; do
  case "$last" in --out) out=$word ;; *) asked="$asked $word" ;; esac
  last=$word
done
number=$(printf %s "$asked" | cksum | cut -d ' ' -f 1)
if [ $((number % 10)) != 0 ] || ! mkdir "$FAULTS/$number" 2>/dev/null; then
  exec "$program" "$@"
fi
case $((number / 10 % 3)) in
  0) echo killed >"$FAULTS/$number/fault"
     mkdir -p "$out" && printf 'frame,' >"$out/frames.csv"  # what a case leaves that was killed while it wrote
     kill -9 $$ ;;
  1) echo memory >"$FAULTS/$number/fault"
     exec prlimit --as=140000000 "$program" "$@" ;;
  2) echo disk >"$FAULTS/$number/fault"
     # The program's own words about a disk that has no room; where nothing can be mounted, the same said for it.
     mountpoint -q "$FAULTS/full" || { echo "musclebench: $out: No space left on device" >&2; exit 2; }
     left=$#
     while [ $left -gt 0 ]; do
       left=$((left - 1)) word=$1
       [ "$word" != "$out" ] || word=$FAULTS/full/run
       shift
       set -- "$@" "$word"
     done
     exec "$program" "$@" ;;
esac
