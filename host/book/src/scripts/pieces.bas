' Glues as many pieces as the panel asks for.
KEEP wanted ' Pieces, 1..50
KEEP made ' Done
made = 0
WHILE made < wanted
  WaitIn 3, ON                 ' a piece lies in the jig
  Pulse 1, 200ms               ' glue
  WaitIn 3, OFF                ' it was taken
  made = made + 1
WEND
