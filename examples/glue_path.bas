' A bead of glue along the rim of a lid, in one go: the valve opens and closes on the way.
' For the MSP430F5529.
PROFILE "mill"
OUTPUT valve = 4
CONST opens = 15ms               ' from the signal to the first glue
CONST thread = 2mm               ' of bead that still comes when the valve has closed

Home
G0 X10 Y20
G0 Z-30
F1200
G1 X20
SYNC SetOut valve, ON, opens
G1 X60                           ' the bead begins here
G1 X70 Y30
G1 Y50
SYNC SetOut valve, OFF, thread
G1 Y70                           ' a gap for the cable
SYNC SetOut valve, ON, opens
G1 Y90
G1 X20
SYNC SetOut valve, OFF, thread
G1 X10
G0 Z0
