#!/bin/sh
# Brings all of it up on this machine: two virtual boards, mosquitto, the gateway; then shows what is told.
# Ctrl-C ends everything. Needs Debian's mosquitto and mosquitto-clients.
set -eu
cd "$(dirname "$0")"
pasapas=${PASAPAS:-pasapas}
PATH=$PATH:/usr/sbin
trap 'trap - INT TERM EXIT; kill $(jobs -p) 2>/dev/null; wait' INT TERM EXIT
mosquitto -p 1883 >/dev/null 2>&1 &
"$pasapas" board --tcp 1601 >/dev/null &
"$pasapas" board --tcp 1602 >/dev/null &
sleep 2
"$pasapas" upload ../counter.bas --port tcp:1601 --any-profile
"$pasapas" gateway hall.toml &
mosquitto_sub -v -t 'pasapas/#' ${1:+-W "$1"} || true
