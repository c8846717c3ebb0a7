/* The 512 bytes of RAM, byte for byte. Everything has a fixed address, so that one byte names
   any word of RAM (formulas). */
    .set HERE, 0x0200
    .macro VAR name, size
    .set \name, HERE
    .global \name
    .set HERE, HERE+\size
    .endm
    /* What follows belongs to this module, up to the next MODULE (`pasapas size`). */
    .macro MODULE name
    .set ram.\name, HERE
    .endm

/* Survive a reset that is no power-up. */
    MODULE boot
    VAR RUNNING, 2              /* RUNS_MARK while a program runs */
    VAR WATCHDOGS, 2            /* NO_WATCHDOGS plus the watchdog resets in a row */
    .set CLEARED, HERE          /* from here on RAM is cleared at reset */

/* Deadlines (ticks.s, step.s). */
    MODULE session$missed
    VAR MISSED, 2               /* milliseconds served late, step events not armed in time */
    VAR RUNS, 2                 /* runs begun since reset */

/* Step engine (step.s). */
    MODULE motion.step
    VAR STEP_SLOT, 2            /* the slot that plays: 0, or SLOT1-SLOT0 */
    VAR STEP_FRAC, 2            /* fraction of the compare registers */
    VAR COUNT, 6                /* low halves of the positions, negated in negative direction */
    VAR WIDTH, 2                /* ticks of a long pulse, 0 for a short one */
    VAR CAUGHT, 4               /* count of axis N when a watched input answered, homing uses it too; else
                                   the speed that overrides act on */
    .set SLOT, HERE
    VAR SLOT0, 12               /* a segment: interval 4, change 4, events 2, mask 2 */
    VAR SLOT1, 12
    VAR INC, 12                 /* what an event adds to each accumulator */
    VAR ACC, 12                 /* accumulators; a carry is a step */

/* Planner (ramp.s, line.s). Scaled numbers but for LEFT. */
    MODULE motion.ramp
    VAR V2, 4                   /* square of the present speed */
    VAR V, 4                    /* its root */
    VAR LEFT, 4                 /* events that no segment has taken yet */
    VAR NOMINAL2, 4             /* square of the speed to run at */
    VAR START2, 4               /* square of the speed from and to rest */
    VAR ACCEL2, 4               /* growth of the square over one event */
    VAR DECEL2, 4               /* its decline while braking */
    VAR TICK, 4                 /* interval at speed 1, ticks */
    .set LOCALS, TICK           /* at rest: bytes of a statement or command that begins */
    VAR WATCH, 1                /* inputs of port 1 that catch, or TRIPPED */
    .if AT_ROOM
    /* at rest, where the pool holds variables: slot_check forgets LEFT again */
    .set CHECK_SCRATCH, INC
    .if WATCH-INC < CHECK_SCRATCH_SIZE
    .error "the check's scratch memory"
    .endif
    .endif
    VAR IDLE, 1                 /* their levels at rest; WATCH_ENDS: the step that is caught is the last */
    VAR HIT, 1                  /* what answered, 0 for nothing yet; where nothing is watched 1 in a rapid
                                   move, LONE in that of a single axis, else 0 */
    VAR REFUSAL, 1              /* Refusal of the last upload */
    VAR MOVING, 1               /* bit per axis that the motion under way moves */
    VAR NEGATIVE, 1             /* bit per axis: last moved in negative direction */
    VAR MOTION, 1               /* M_ flags */
    VAR HOMED, 1                /* bit per axis */
    MODULE micro
    VAR TEMP, 12                /* scratch of one routine, never across a pass of the main loop */

/* Positions, 3 x 32 bits each. */
    MODULE moves
    VAR UM, 12                  /* commanded machine positions, um */
    VAR STEPS, 12               /* the same in steps */
    VAR OFFSET, 12              /* work offsets: machine less work position, um */
    VAR ACTUAL, 12              /* machine positions at this instant, steps */
    VAR PROBED, 12              /* where the probe answered, steps */
    VAR PROBE_OK, 1             /* bit per axis: its last probe answered */
    VAR HOMING_ERROR, 1         /* bit per axis: homing by command failed */
    VAR PROBE_ERROR, 1
    VAR CAUSE, 1                /* IFG1 at reset */

/* Link (uart.s, modbus.s). */
    MODULE link
    VAR FRAME, 52               /* request, then ring of the reply */
    VAR HEAD, 1                 /* receiving: bytes so far; sending: where the next byte goes */
    VAR TAIL, 1                 /* sending: the next byte to go out */
    VAR LINE_STATE, 1
    VAR FUNCTION, 1             /* reading function whose data is being sent, 0 for none */
    VAR SILENCE_TICKS, 2        /* from a character's end to the frame's end, 0.5 us */
    VAR SLACK_TICKS, 2
    VAR NEXT_REGISTER, 2
    VAR REGISTERS_LEFT, 2
    VAR REPLY_CRC, 2
    VAR COMMAND_HEAD, 4         /* a command's number and first argument, the others in COMMAND */

/* Run state (session.s, ticks.s). */
    MODULE session
    VAR EFFECT_PC, 2            /* address of the effect's instruction, or of the next one */
    VAR FEED, 4                 /* F: um/s, negative steps/s, 0 none yet */
    VAR MILLIS, 2               /* milliseconds since reset */
    VAR HELD, 2                 /* milliseconds for which Stop must still be held to end a run */
    VAR UNHEARD, 2              /* milliseconds since a host took what was printed, or found nothing */
    VAR RUN, 1                  /* RunState, without WaitStart */
    VAR CHAR_IN, 1

/* Inputs and outputs (io.s). */
    MODULE io
    VAR INPUT, 2                /* filtered inputs 1 to 16 */
    VAR INPUT_LOW, 2            /* bits of their counters */
    VAR INPUT_HIGH, 2
    VAR RAW, 2                  /* inputs before the filter */
    VAR BUTTON, 1               /* P1_STOP, P1_START: pressed; filtered; the other bits of P1 too */
    VAR ADDRESS, 1              /* the link's */
    VAR BUTTON_LOW, 1           /* counters 2 and 4 bytes behind, as those of INPUT */
    VAR TICKS_DONE, 1           /* low byte of the millisecond handled last */
    VAR BUTTON_HIGH, 1
    VAR RUN_FLAGS, 1            /* R_ flags */
    VAR OVERRIDE, 2             /* percent: of feeds and single axes, of rapid moves */
    VAR FORCED, 2               /* inputs that keep the level that command 110 gave them */
    VAR OUTPUT, 2               /* outputs 1 to 16 */
    VAR RESUME_OUTPUT, 2        /* outputs as they were before a pause */
    VAR BOARD, 2                /* address of the board's profile in flash */

/* Store (store.s). */
    MODULE store
    VAR STORED, 2               /* address of the current slot, 0 for none */

/* Characters and print (effects.s, print.s). */
    MODULE effects.print
    VAR CHAR_OUT, 2             /* character, count of them */
    VAR PRINT_TAIL, 2           /* number of the first byte that waits */
    VAR PRINT_READY, 1          /* bytes that wait and that the host may take */
    VAR TRACING, 1              /* T_ flags */
    .set PRINT_SIZE, 16
    VAR PRINT, PRINT_SIZE

/* VM (vm.rs, State). */
    .set VM_STATE, HERE
    MODULE vm
    VAR VM_PC, 2
    VAR VM_SP, 2                /* address of the value below the top */
    VAR VM_TOP, 4
    VAR VM_CODE, 2              /* address of the code, 0 without a program */
    VAR VM_CELLS, 2             /* also the end of the call stack, which they follow */
    VAR VM_CALLS, 2             /* place of the next entry of the call stack */
    VAR VM_BASE, 2
    VAR VM_DATA, 2
    .set RUN_CLEARED, HERE      /* from here to the pool's end RAM is cleared when a run begins */
    VAR VM_HANDLER, 2
    VAR VM_FAULT_PC, 2
    VAR VM_FAULT, 1             /* last fault; also what the link shows */
    VAR FAULT_IN, 1             /* input that caused it */
    VAR VM_POLL, 1
    VAR VM_FLAGS, 1
    VAR VM_CELL_COUNT, 1
    VAR ENDING, 1               /* End that the run comes to when everything rests, 0 for a pause */

    VAR PLACED, 1               /* bit per axis: SetPos has said where it is, in this run */
    VAR LAST_END, 1             /* End of the last run, 0 in a run */

/* The effect under way (effects.s). */
    MODULE effects
    VAR EFFECT, 1               /* its opcode, 0 for none, EFFECT_END at the end of a run */
    VAR PHASE, 1                /* what it has come to, 0 at its beginning */
    VAR N, 1                    /* input, output, axis, character */
    VAR BITS, 1                 /* flags of the instruction */
    VAR TIME, 4                 /* milliseconds to go, negative for ever; or whatever it needs; the high
                                   half is 0 at its beginning */

/* Trace (trace.s), in the order of the slot's registers. */
    MODULE effects.trace
    VAR TRACE_NUMBER, 2         /* number of the last event */
    VAR TRACE_KIND, 1
    VAR TRACE_ARGUMENT, 1
    VAR TRACE_PC, 2
    VAR TRACE_VALUE, 4

    MODULE session$run
    VAR TIMER_MS, 4             /* milliseconds of the run */
    .if HAS_LINES
    VAR SPIN, 2                 /* milliseconds until motion goes on after a pause */
    .else
    /* without handlers */
    .set SPIN, VM_HANDLER
    .endif
    VAR PRINT_OPEN, 1           /* bytes of the line that is being put */
    VAR FILTER, 1               /* four times the milliseconds since the last sample of inputs */
    VAR OPEN, 2                 /* address of the slot that an upload fills, 0 for none */
    VAR UPLOAD, 2               /* announced length, bit 15 KEEP */
    /* A run gives an upload up: F while an error handler is open lies in its place. */
    .set FEED_ASIDE, OPEN

/* The program's pool: call stack upward, cells, expression stack downward from POOL_END. Without a
   run its end holds the command buffer; cells of AT variables in front of that live on. */
    MODULE pool
    .set POOL, HERE
    .set STACK_ROOM, 70-2*HAS_LINES /* the machine stack below 0x0400, with 24 bytes to spare */
    .set POOL_END, 0x0400-STACK_ROOM
    .set COMMAND, POOL_END-42   /* 21 registers, the first two of them in COMMAND_HEAD */
    .set HOME_RECORD, COMMAND-4 /* the arguments of 106 as a record of an axis */
    .if AT_ROOM && HOME_RECORD-POOL != AT_ROOM
    .error "the part's room for AT variables"
    .endif
    .if !AT_ROOM
    .set CHECK_SCRATCH, POOL
    .endif
    .set ram.stack, POOL_END
    .global POOL, POOL_END, VM_STATE

/* HIT */
    .set LONE, -1
/* MOTION: how the motion under way goes on */
    .set M_PAUSE, 1             /* brake to a pause, or rest in one */
    .set M_STOP, 2              /* brake, then forget the rest */
    .set M_SETTLE, 4            /* the commanded places will be where it ends */
    .set M_JOG, 32              /* brake when the host falls silent; the link's bit for it */
/* WATCH: no more steps are made */
    .set WATCH_ENDS, 1
/* WATCH: so, as an emergency stop has answered at its pin */
    .set TRIPPED, -1
/* RUN_FLAGS */
    .set R_WAITING, 1           /* WaitStart, and Start was not pressed yet */
    .set R_BOOTED, 2            /* half a second has passed since reset */
    .set R_TIMED_OUT, 4         /* TIMEDOUT */
    .set R_HOST, 8              /* a host has spoken since reset */
    .set R_HALF, 16             /* the low word of a lock code was given */
    .set R_WRONG, 32            /* a word of a lock code was wrong: none is taken until reset */
    .set R_RESTART, 128         /* reset the chip once the reply is out; its sign */
/* TRACING */
    .set T_ON, 1                /* trace mode */
    .set T_FULL, 2              /* the slot holds an event that was not received */
    .set T_ANNOUNCED, 4         /* the host knows of the line that is being printed */
    .set T_DROPPED, 8           /* the line that is being put does not fit */
    .set T_QUARTER, 16          /* a quarter of a second, of those left until trace mode ends: */
    .set T_HEARD, 7*T_QUARTER
    .set T_LOCKED, 128          /* program and profile are locked; its sign */
/* EFFECT */
    .set EFFECT_END, 0xfe       /* no opcode of this part */
/* What an effect returns in r12, besides FAULTED + fault number. */
    .set DONE, 0
