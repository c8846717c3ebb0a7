#!/bin/sh
# Graphs of the boards of up.sh, or of any gateway with a broker on this machine: Debian's prometheus and
# prometheus-mqtt-exporter on this machine's own address. Open http://127.0.0.1:9090/graph and ask for pasapas_runs or
# pasapas_x_steps. Ctrl-C ends it; what was measured is kept nowhere.
set -eu
cd "$(dirname "$0")"
. ./children.sh
data=$(mktemp -d)
trap 'trap - EXIT; kill $children 2>/dev/null || true; wait; rm -r "$data"' EXIT
begin prometheus-mqtt-exporter -config mqtt.yaml -listen-address 127.0.0.1 -log-level error
begin prometheus --config.file=prometheus.yaml --storage.tsdb.path="$data" --web.listen-address=127.0.0.1:9090 \
    --log.level=error
wait
