' RISE as a name of the script.
DIM rise(4), fall
fall = rise(2)
PRINT fall
