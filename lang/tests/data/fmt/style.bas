rem a script   
profile "mill"
dim  i,px as length , speed:keep parts
table spots( 2 )=10MM,5mm;20mm , -5mm
for i=1 to 10 step -2
   ' a comment
if in( 3 )then
moveaxe x , -5MM , 2000ST/S    ' trailing   
elseif not(i=3)or i<-2 then
px=-5mm+pos( x )*-i/(2-1)
   else
 waitin? 3,rise,5s:start moverel y,-1mm
 if i then setout 1,on else g0x5y[ i*2mm ]f[ speed ] (remark)
end if
again:i=i+1
  other:
next i
select case i
case 1,3 to 5,is<0
wait 5ms
case else
goto again
end select

on in 3 rise gosub jam:on error stop
g1x10 _
y20
plane xy
show -5,i
show(1),2
jam:return
sub show(a as speed,b)
do:loop until i>=2:repeat 3:end repeat
print "a";a;"b"; -b
i=a<<2 and&hff
end sub
; a G-code comment
 % and one more
TABLE long(2) = 1, 2; _
                3, 4; _
 5, 6
table named(2)=1,2; _'glued
  3,4; _     ' left   
  5,6 ' right
g1 x1 _ ' half
  y2
i-5 j0 x10
dim label at 3000 label "Pieces"  min -5  max 10,b at 3002 max count (spots)-1
dim first=5,second(2)=1,-2
wait until first>2,50ms
first.3=first.2 and not  second(1).0
s.3=on
