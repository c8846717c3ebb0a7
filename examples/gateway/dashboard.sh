#!/bin/sh
# Graphs of the boards of up.sh, or of any gateway with a broker on this machine: Debian's prometheus and
# prometheus-mqtt-exporter on this machine's own address. Open http://127.0.0.1:9090/graph and ask for pasapas_runs or
# pasapas_x_steps. Ctrl-C ends it; what was measured is kept nowhere.
set -eu
cd "$(dirname "$0")"
data=$(mktemp -d)
trap 'trap - INT TERM EXIT; kill $(jobs -p) 2>/dev/null; wait; rm -r "$data"' INT TERM EXIT
prometheus-mqtt-exporter -config mqtt.yaml -listen-address 127.0.0.1 -log-level error &
prometheus --config.file=prometheus.yaml --storage.tsdb.path="$data" --web.listen-address=127.0.0.1:9090 \
    --log.level=error &
wait
