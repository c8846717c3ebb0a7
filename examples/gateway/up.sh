#!/bin/sh
# Brings all of it up on this machine: two virtual boards, mosquitto, the gateway; then shows what is told.
# Ctrl-C ends everything, and so does a number of seconds as argument. Needs Debian's mosquitto and
# mosquitto-clients.
set -eu
cd "$(dirname "$0")"
pasapas=${PASAPAS:-pasapas}
PATH=$PATH:/usr/sbin
. ./children.sh
begin mosquitto -p 1883 >/dev/null 2>&1
begin "$pasapas" board --tcp 1601 >/dev/null
begin "$pasapas" board --tcp 1602 >/dev/null
sleep 2
"$pasapas" upload ../counter.bas --port tcp:1601 --any-profile
begin "$pasapas" gateway hall.toml
sleep 1
# What kept it from starting was said.
kill -0 "$last"
begin mosquitto_sub -v -t 'pasapas/#' ${1:+-W "$1"}
# It ends by itself when its time is over.
wait "$last" || true
