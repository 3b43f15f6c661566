#!/bin/sh
# Stands in for the program where it is started a thousand times: writes a run or a recording in pieces; its answers depend
# on what it was asked, not on the repetition. `list` and `probe` are those of the slower stand-in. FAKE_HANGS: the repetition
# that does not end.
set -e
case $1 in list | probe) exec /usr/bin/python3 "$(dirname "$0")/fake_musclebench.py" "$@" ;; esac
out= asked= last=
for word; do
  case "$last $word" in
    "--out "*) out=$word ;;
    "--backend "*) backend=$word asked="$asked $word" ;;
    "--repetition "*) repetition=$word ;;
    *" --repetition" | *" --no-referee") ;;
    *) asked="$asked ${word##*/}" ;;
  esac
  last=$word
done
set -- "$1" "${2##*/}" $(printf %s "$asked" | cksum)
if [ "$1" = record ]; then
  printf 'positions of ' >"$out"
  printf '%s' "$asked" >>"$out"
  exit 0
fi
[ "$1" = run ] && mode=coupled hash=state_hash || mode=replay hash=contact_hash
mkdir -p "$out"
echo "frame,angle_deg,warm_up,update_ns,detect_ns,respond_ns,frame_ns,contacts,true_contacts,nodes_inside,max_depth_m,mean_depth_m,missed_contacts,false_contacts,measured_contacts,max_depth_error_m,p99_depth_error_m,mean_depth_error_m,resident_bytes" >"$out/frames.csv"
case "$repetition" in "${FAKE_HANGS:-none}") sleep 60 ;; esac
printf '1,0,0,1,1,1,4,%s,3,1,0.001,0.001,0,0,3,1e-6,1e-6,1e-7,1\n2,0,0,1,1,' "$3" >>"$out/frames.csv"
[ -n "$FAKE_SLEEP" ] && sleep "$FAKE_SLEEP"
printf '1,4,%s,3,1,0.002,0.001,1,0,3,1e-6,1e-6,1e-7,1\n' "$4" >>"$out/frames.csv"
printf '{"status": "ok", "status_detail": "", "%s": "%s", "frames": 2, ' "$hash" "$3" >"$out/run.json"
printf '"case": {"mode": "%s", "scene": "synthetic/%s", "backend": "%s", "parameters": {}, "threads": 1, "repetition": %s}}\n' \
  "$mode" "$2" "$backend" "$repetition" >>"$out/run.json"
